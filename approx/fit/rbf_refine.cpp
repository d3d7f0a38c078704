// Checks of a kept factor, and iterative refinement of the coefficients.

#include <algorithm>
#include <cmath>
#include <limits>

#include "approx/fit/rbf_fit.hpp"
#include "approx/loops/exact_sums.hpp"

namespace forefeel {
using namespace detail;

namespace {

// Number of states checked at a time. Evaluating a model there costs little compared with its update.
constexpr std::size_t watched(std::size_t n) {
  return n <= 16 ? n : n <= 32 ? 16 : 8;
}
// Limits beyond which digits count as lost. Factors of lattice sets, fresh or updated, stay below them by a
// factor of two or more (25 to 75 Hermite states, 100 to 300 plain ones).
constexpr double lost = 3e-14;        // misfit, per 100 rows, and P^T lambda, in units of the largest force
constexpr double least_pivot = 1e-5;  // of K
constexpr double least_determined = 1e-3;  // pivot ratio of P
constexpr int most_refinements = 6;
constexpr std::size_t most_refined = 32;  // states; a refit of more takes less time than a refinement
constexpr double settled = 1e-8;          // last correction against the coefficients

}  // namespace

bool RbfFit::has_lost_digits(const ModelData& out) {
  const std::size_t n = living_.size(), q = terms_;
  const auto [weakest, inverse] = factor_.weakest_row();
  double least = std::abs(upper_[0]), most = least;
  for (std::size_t j = 1; j < q; ++j) {
    least = std::min(least, std::abs(upper_[j * q + j]));
    most = std::max(most, std::abs(upper_[j * q + j]));
  }
  if (!(inverse * inverse * least_pivot < 1) || !(least > least_determined * most)) return true;

  double largest = 0;
  for (const std::uint32_t s : living_) largest = std::max(largest, slot_array(force_norm)[s]);
  double sums[3 * max_terms];
  dense::loops().dots3(q, factor_.rows(), orthogonal_.data() + q * row_stride_, lagrange_.data(), row_stride_,
                       sums);
  for (std::size_t k = 0; k < 3 * q; ++k)
    if (!(std::abs(sums[k]) <= lost * largest)) {
      worn_ = updated_;
      return true;
    }

  const double per_row = out.power == 5 && !out.hermite ? 0.04 : 0.01;  // r^5 alone loses more
  const double allowed = lost * largest * std::max(0.4, per_row * double(factor_.rows()));
  const auto missed = [&](std::size_t i) {
    const std::uint32_t s = living_[i];
    if (slot_[s].dropped != 0) return false;
    const double y[3] = {px_[s], py_[s], pz_[s]};
    double f[3];
    out.raw(y, f);
    double squared = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double left =
          slot_array(force + c)[s] - f[c] - sign_ * ridge(s, 0) * out.data[(3 + c) * out.stride + i];
      squared += left * left;
    }
    return !(squared <= allowed * allowed);
  };
  // Checks the state with the smallest pivot, where errors appear first, and others in turn.
  bool lost_some = false;
  const auto at = std::ranges::lower_bound(living_, static_cast<std::uint32_t>(weakest / rows_per_slot_));
  if (at != living_.end()) lost_some = missed(static_cast<std::size_t>(at - living_.begin()));
  if (!updated_) watched_ = 0;
  for (std::size_t t = 0; t < watched(n) && !lost_some; ++t) {
    watched_ = watched_ + 1 < n ? watched_ + 1 : 0;
    lost_some = missed(watched_);
  }
  if (lost_some) worn_ = updated_;
  return lost_some;
}

// The misfit of the model at its states, into misfit_ and, in the order of the factor's rows, into
// correction_. Returns its largest entry.
double RbfFit::misfit(const ModelData& out) {
  const std::size_t b = rows_per_slot_;
  exact::loops().misfit(out.power, b == 4, out.padded, out.data.data(), out.stride, out.polynomial[0].data(),
                        given_.data(), given_stride_, misfit_.data());
  double largest = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    double* to = correction_.data() + c * row_stride_;
    std::fill_n(to, row_stride_, 0.0);  // all of it: an earlier, larger set must leave nothing
    for (std::size_t i = 0; i < living_.size(); ++i)
      for (std::size_t t = 0; t < b; ++t) {
        const std::size_t row = living_[i] * b + t;
        if (weight_[row] == 0) continue;
        const std::size_t array = t == 0 ? c : 2 + 3 * c + t;
        const double left = misfit_[array * given_stride_ + i] -
                            sign_ * ridge(living_[i], t) * out.data[(3 + array) * out.stride + i];
        to[row] = left;
        largest = std::max(largest, std::abs(left));
      }
  }
  return largest;
}

// rest = -P^T lambda, which should be zero.
void RbfFit::constraint(const ModelData& out, double* rest) const {
  const std::size_t b = rows_per_slot_, q = terms_;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t j = 0; j < q; ++j) {
      long double sum = 0;
      for (std::size_t i = 0; i < living_.size(); ++i)
        for (std::size_t t = 0; t < b; ++t)
          sum -= static_cast<long double>(out.data[(3 + (t == 0 ? c : 2 + 3 * c + t)) * out.stride + i]) *
                 lagrange_[j * row_stride_ + living_[i] * b + t];
      rest[c * q + j] = sign_ * static_cast<double>(sum);
    }
}

// Adds `by` (1 or -1) times the correction to the model.
void RbfFit::correct(ModelData& out, double by) {
  const std::size_t b = rows_per_slot_;
  for (std::size_t c = 0; c < 3; ++c) {
    const double* lambda = correction_.data() + c * row_stride_;
    for (std::size_t i = 0; i < living_.size(); ++i)
      for (std::size_t t = 0; t < b; ++t)
        out.data[(3 + (t == 0 ? c : 2 + 3 * c + t)) * out.stride + i] +=
            by * sign_ * lambda[living_[i] * b + t];
    for (std::size_t t = 0; t < max_terms; ++t) out.polynomial[t][c] += by * polynomial_correction_[c][t];
  }
}

// A round of refinement sums over all pairs of states in twice the working precision, so for larger sets a
// refit is faster.
bool RbfFit::refit_is_cheaper() const {
  return mode_ == Mode::automatic && updated_ && alive_ > most_refined;
}

// The data that the model must reproduce at its own states: forces, and derivatives if it uses stiffness.
void RbfFit::load_given() {
  for (std::size_t i = 0; i < living_.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t s = living_[i];
      given_[c * given_stride_ + i] = slot_array(force + c)[s];
      if (rows_per_slot_ == 4)
        for (std::size_t d = 0; d < 3; ++d)
          given_[(3 + 3 * c + d) * given_stride_ + i] = -slot_array(stiffness + 3 * c + d)[s] * scale_;
    }
}

// Solves for the change of the coefficients that removes the misfit, with the present factor: correction_ (of lambda)
// and polynomial_correction_.
void RbfFit::solve_correction(const ModelData& out) {
  const std::size_t q = terms_, m = factor_.rows();
  // With w = L^T delta lambda: Q^T w = R^-T rest and w = L^-1 misfit beyond Q.
  double rest[3 * max_terms];
  constraint(out, rest);
  factor_.solve(correction_.data(), row_stride_);
  for (std::size_t c = 0; c < 3; ++c) {
    std::fill_n(correction_.data() + c * row_stride_ + m, 8, 0.0);
    for (std::size_t j = 0; j < q; ++j) {
      double value = rest[c * q + j];
      for (std::size_t k = 0; k < j; ++k) value -= upper_[k * q + j] * rest[c * q + k];
      rest[c * q + j] = value / upper_[j * q + j];
    }
  }
  double along[3 * max_terms], total[3 * max_terms] = {};
  for (int pass = 0; pass < 2; ++pass) {  // the second pass removes the rounding error of the first
    dense::loops().dots3(q, m, correction_.data(), orthogonal_.data(), row_stride_, along);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t j = 0; j < q; ++j) {
        const double taken = along[c * q + j] - rest[c * q + j];
        total[c * q + j] += taken;
        for (std::size_t r = 0; r < m; ++r)
          correction_[c * row_stride_ + r] -= taken * orthogonal_[j * row_stride_ + r];
      }
  }
  double* z = correction_.data();
  factor_.solve_transposed(z, z + row_stride_, z + 2 * row_stride_);
  for (std::size_t c = 0; c < 3; ++c) std::fill_n(z + c * row_stride_ + m, 8, 0.0);
  double sums[3 * max_terms];
  dense::loops().dots3(q, m, z, dual_.data(), row_stride_, sums);
  for (std::size_t c = 0; c < 3; ++c) {
    double values[max_terms];
    for (std::size_t j = q; j-- > 0;) {
      double value = total[c * q + j];
      for (std::size_t k = j + 1; k < q; ++k) value -= upper_[j * q + k] * values[k];
      values[j] = value / upper_[j * q + j];
    }
    for (std::size_t j = 0; j < q; ++j) values[j] -= sign_ * sums[c * q + j];
    to_monomials(level_.degree, values, polynomial_correction_[c]);
  }
}

// Iterative refinement of the coefficients. False if it did not converge: the factor has lost too many
// digits.
bool RbfFit::refine(ModelData& out) {
  load_given();
  const double before = misfit(out);
  double last = std::numeric_limits<double>::infinity();
  for (int round = 0; round < most_refinements; ++round) {
    solve_correction(out);
    const double* z = correction_.data();
    double size = 0;
    for (std::size_t i = 0; i < 3 * row_stride_; ++i) size = std::max(size, std::abs(z[i]));
    // Stop if it no longer converges or is not a number. The first rounds may reduce one component after the
    // other.
    if (!(size < (round < 3 ? 2 : 0.5) * last)) break;
    last = size;
    correct(out, 1);
    std::copy_n(correction_.data(), 3 * row_stride_, last_correction_.data());
    const double after = misfit(out);
    if (after <= 2 * before) continue;
    std::copy_n(last_correction_.data(), 3 * row_stride_, correction_.data());  // made it worse: undo
    correct(out, -1);
    return false;
  }
  double largest = 0;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < living_.size(); ++i)
      largest = std::max(largest, std::abs(out.data[(3 + c) * out.stride + i]));
  return last <= settled * largest;
}

}  // namespace forefeel
