// K and V of the states of a lane solver, by conjugate gradients.
#include <algorithm>

#include "solver/equilibrium/lane_solver.hpp"

namespace forefeel {
namespace {

// If the last correction of V changed K by the relative amount g, and a step with the factor leaves the share
// e of an error, the relative error of K that remains is about e g.
constexpr double settled_share = 2e-5, largest_gain = 3e-3, least_contraction = 0.03, most_contraction = 0.7,
                 unknown_contraction = 0.2;

}  // namespace

// Conjugate gradients for V, preconditioned with M, for each lane and each column c of V:
//   rho = -(H [V; I])_f   z = M^-1 rho   p = z + p rho^T z / (rho^T z)'   V += p rho^T z / (p^T H p)
// y = H [V; I] (product_) follows by y += H p alpha. At the end V += z.
void LaneSolver::finish(const Factorisation& factor, int count, int rounds,
                        std::array<LaneResult, lane_count>& results) {
  const FrontKernels& k = front_kernels();
  const auto rows = static_cast<std::int64_t>(3 * d_->free_nodes);
  const auto stride = static_cast<std::int64_t>(size_);
  double *z = history_.data(), *p = z + 3 * size_, *q = p + 3 * size_;
  std::fill_n(p, 3 * size_, 0.0);
  std::array<LaneMask, 3> before{};
  LaneMask one;
  one.fill(1);
  std::fill(product_.begin(), product_.end(), 0.0);
  d_->elements.product_lanes(stride, u_.data(), tangent_.data(), product_.data());
  for (int round = 0;; ++round) {
    for (std::size_t i = 0; i < 3 * size_; ++i) z[i] = -product_[i];
    for (std::size_t c = 0; c < 3; ++c) {
      factor.solve_lanes(&z[c * size_]);
      std::fill_n(&z[c * size_ + static_cast<std::size_t>(rows) * lane_count], 6 * lane_count, 0.0);
    }
    std::array<LaneMask, 3> square;
    const bool settled = condense_lanes(z, count, results, square);
    if (settled || round + 1 >= rounds) break;
    for (std::size_t c = 0; c < 3; ++c) {
      LaneMask share;
      for (std::size_t l = 0; l < lane_count; ++l)
        share[l] = round > 0 && before[c][l] > 0 ? square[c][l] / before[c][l] : 0.0;
      scale_lanes(share, &p[c * size_], size_);
      k.add_lanes(stride / lane_count, one.data(), &z[c * size_], &p[c * size_]);
    }
    std::fill_n(q, 3 * size_, 0.0);
    d_->elements.product_lanes(stride, u_.data(), p, q);
    for (std::size_t c = 0; c < 3; ++c) {
      LaneMask length;
      k.dot_lanes(rows, &p[c * size_], &q[c * size_], length.data());
      for (std::size_t l = 0; l < lane_count; ++l)
        length[l] = length[l] > 0 ? square[c][l] / length[l] : 0.0;  // otherwise H is not positive definite
      k.add_lanes(stride / lane_count, length.data(), &p[c * size_], &tangent_[c * size_]);
      k.add_lanes(stride / lane_count, length.data(), &q[c * size_], &product_[c * size_]);
    }
    before = square;
  }
  LaneMask dot{};
  for (unsigned c = 0; c < 3; ++c) {
    k.add_lanes(stride / lane_count, one.data(), &z[c * size_], &tangent_[c * size_]);
    k.dot_lanes(rows, &tangent_[c * size_], residual_.data(), dot.data());
    for (std::size_t l = 0; l < static_cast<std::size_t>(count); ++l)
      if (results[l].stiffness_settled) results[l].force[c] -= dot[l];
  }
}

// K from V, y = H [V; I] and z, the correction of V; square: rho^T z by column. True if K is valid in all lanes that
// converged.
bool LaneSolver::condense_lanes(const double* z, int count, std::array<LaneResult, lane_count>& results,
                                std::array<LaneMask, 3>& square) const {
  const FrontKernels& k = front_kernels();
  const auto rows = static_cast<std::int64_t>(3 * d_->free_nodes);
  std::array<Mat3, lane_count> plain, gain;
  LaneMask dot{};
  for (unsigned a = 0; a < 3; ++a)
    for (unsigned b = a; b < 3; ++b) {
      const double* y = &product_[b * size_];
      k.dot_lanes(rows, &tangent_[a * size_], y, dot.data());
      for (std::size_t l = 0; l < lane_count; ++l)
        plain[l](a, b) = plain[l](b, a) = dot[l] + y[(static_cast<std::size_t>(rows) + a) * lane_count + l];
      k.dot_lanes(rows, &product_[a * size_], &z[b * size_], dot.data());
      for (std::size_t l = 0; l < lane_count; ++l) gain[l](a, b) = gain[l](b, a) = -dot[l];
    }
  for (unsigned c = 0; c < 3; ++c)
    for (std::size_t l = 0; l < lane_count; ++l) square[c][l] = gain[l](c, c);
  bool settled = true;
  for (std::size_t l = 0; l < static_cast<std::size_t>(count); ++l) {
    LaneResult& result = results[l];
    result.stiffness = plain[l] - gain[l];
    const double share = gain[l].norm() / result.stiffness.norm();
    const double left = result.iterations > 0
                            ? std::clamp(result.contraction, least_contraction, most_contraction)
                            : unknown_contraction;
    result.stiffness_settled = share <= largest_gain && left * share <= settled_share;
    settled = settled && (result.stiffness_settled || !result.converged);
  }
  return settled;
}

}  // namespace forefeel
