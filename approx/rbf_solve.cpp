// The coefficients from the factor, and the model made of them.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "approx/dense_kernels.hpp"
#include "approx/rbf_fit.hpp"

namespace forefeel {
// min |Y_P c - Y_f| by modified Gram-Schmidt on [Y_P Y_f], whose last columns become the residual; then
// lambda = L^-T residual. P^T lambda = 0 is as exact as the residual is orthogonal.
void RbfFit::solve() {
  const std::size_t m = factor_.rows(), q = terms_;
  for (std::size_t r = 0; r < m; ++r) {
    const double* from = factor_.border_row(r);
    for (std::size_t j = 0; j < q + 3; ++j) orthogonal_[j * row_stride_ + r] = from[j];
  }
  double upper[max_terms * max_terms], right[3 * max_terms];
  dense::orthogonalise(q, m, orthogonal_.data(), row_stride_, upper, right);
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t j = q; j-- > 0;) {
      double value = right[c * q + j];
      for (std::size_t k = j + 1; k < q; ++k) value -= upper[j * q + k] * coefficient_[c][k];
      coefficient_[c][j] = value / upper[j * q + j];
    }
  double* residual = orthogonal_.data() + q * row_stride_;
  factor_.solve_transposed(residual, residual + row_stride_, residual + 2 * row_stride_);
}

// Back from the projected kernel to phi: only the polynomial changes, by -s sum_b lambda_b v_b.
void RbfFit::write_sum(Model::Impl& out) {
  solve();
  const std::size_t m = factor_.rows();
  for (int c = 0; c < 3; ++c) {
    const double* lambda = orthogonal_.data() + (terms_ + c) * row_stride_;
    double values[max_terms];
    for (std::size_t j = 0; j < terms_; ++j) {
      const double* v = dual_.data() + j * row_stride_;
      double sum = 0;
      for (std::size_t r = 0; r < m; ++r) sum += lambda[r] * v[r];
      values[j] = coefficient_[c][j] - sign_ * sum;
    }
    to_monomials(level_.degree, values, out.polynomial[c].data());
  }
  std::size_t n = 0;
  const std::size_t stride = out.stride, b = rows_per_slot_;
  for (std::size_t s = 0; s < slots_; ++s) {
    if (!slot_[s].alive) continue;
    double* to = out.data.data() + n;
    to[0] = px_[s];
    to[stride] = py_[s];
    to[2 * stride] = pz_[s];
    for (int c = 0; c < 3; ++c) {
      const double* lambda = orthogonal_.data() + (terms_ + c) * row_stride_ + s * b;
      to[(3 + c) * stride] = sign_ * lambda[0];
      if (b == 4)
        for (std::size_t d = 0; d < 3; ++d) to[(6 + 3 * c + d) * stride] = sign_ * lambda[1 + d];
    }
    ++n;
  }
  out.padded = (n + 7) / 8 * 8;
  for (std::size_t a = 0; a < (b == 4 ? 15u : 6u); ++a)
    std::fill(out.data.data() + a * stride + n, out.data.data() + a * stride + out.padded, 0.0);
}

// Tangent, hold distance and bound (see model_data.hpp).
void RbfFit::write_tangent(Model::Impl& out, const Vec3& hip) {
  double nearest = 1e300, farthest = 0, largest_force = 0, largest_stiffness = 0, spread = 0;
  std::size_t first = 0, count = 0;
  for (std::size_t s = 0; s < slots_; ++s) {
    if (!slot_[s].alive) continue;
    const Sample& a = slot_[s].sample;
    const double distance = (a.at - hip).norm();
    if (distance < nearest) {
      nearest = distance;
      first = s;
    }
    farthest = std::max(farthest, distance);
    largest_force = std::max(largest_force, slot_[s].force_norm);
    largest_stiffness = std::max(largest_stiffness, slot_[s].stiffness_norm);
    spread += (a.at - centre_).squaredNorm();
    ++count;
  }
  const Sample& base = slot_[first].sample;
  const double radius = std::sqrt(spread / double(count));
  double length = std::max(radius, options_.length);
  if (length == 0 && base.stiffness.norm() > 0) length = base.force.norm() / base.stiffness.norm();
  if (!(length > 0)) length = base.at.norm() > 0 ? 0.25 * base.at.norm() : 0.005;
  out.trust = 1.5 * length * inverse_scale_;
  out.hold = 4 * length;

  // Weights fall to zero at the farthest state, so that the tangent moves gradually as the set does.
  double total = 0, slope = 0;
  Vec3 at = Vec3::Zero(), force = Vec3::Zero();
  Mat3 jacobian = Mat3::Zero();
  bool stiffness_known = true;
  const double floor = 1e-6 * farthest + 1e-300;
  for (std::size_t s = 0; s < slots_; ++s) {
    if (!slot_[s].alive) continue;
    const Sample& a = slot_[s].sample;
    const double distance = std::max((a.at - hip).norm(), floor);
    const double ratio = count > 1 ? (farthest / distance - 1) * nearest / (farthest + floor) : 1;
    const double w = ratio > 0 ? ratio * ratio : s == first ? 1e-12 : 0;
    const Vec3 from = a.at - base.at;
    if (largest_stiffness == 0) {
      const double apart = from.norm();
      if (apart > 1e-3 * farthest) slope = std::max(slope, (a.force - base.force).norm() / apart);
    }
    if (w == 0) continue;
    total += w;
    at += w * from;
    force += w * a.force;
    if (slot_[s].stiffness_norm > 0) {
      force += w * (a.stiffness * from);
      jacobian -= w * a.stiffness;
    } else {
      stiffness_known = false;
    }
  }
  if (largest_stiffness == 0) largest_stiffness = 2 * slope;
  out.bound = 1.25 * (largest_force + largest_stiffness * out.hold);
  out.tangent_at = base.at + at / total;
  if (stiffness_known) {  // mean of f_i - K_i (x - x_i) about the mean position
    out.tangent_jacobian = jacobian / total;
    out.tangent_force = force / total + out.tangent_jacobian * (at / total);
  } else {
    out.tangent_force = base.force;
    out.tangent_at = base.at;
    out.tangent_jacobian.setZero();
  }
  if (!stiffness_known && out.power != 0) {
    const Vec3 y = scaled(out.tangent_at);
    double f[3], j[9];
    out.raw(y.data(), f, j);
    for (int c = 0; c < 3; ++c)
      for (int d = 0; d < 3; ++d) out.tangent_jacobian(c, d) = j[3 * c + d] * inverse_scale_;
    const double norm = out.tangent_jacobian.norm();
    if (!(norm <= largest_stiffness)) {
      if (std::isfinite(norm) && norm > 0)
        out.tangent_jacobian *= largest_stiffness / norm;
      else
        out.tangent_jacobian.setZero();
    }
  }
}

void RbfFit::write(Model::Impl& out, const Vec3& hip) {
  out.clear();
  if (alive_ == 0) return;
  out.reserve(alive_, level_.hermite);
  std::size_t carrying = 0;
  for (std::size_t s = 0; s < slots_; ++s) {
    if (!slot_[s].alive) continue;
    out.states.push_back(slot_[s].sample.id);
    if ((slot_[s].dropped & 1u) == 0) ++carrying;
  }
  out.centre = centre_;
  out.scale = scale_;
  out.inverse_scale = inverse_scale_;
  out.degree = level_.degree;
  out.hermite = level_.hermite;
  out.kernel = level_.power == 1 ? Kernel::linear : level_.power == 3 ? Kernel::cubic : Kernel::quintic;
  out.power = carrying > 1 ? level_.power : 0;
  if (out.power != 0) write_sum(out);
  write_tangent(out, hip);
  if (out.power != 0)
    out.set_hull(out.data.data(), out.data.data() + out.stride, out.data.data() + 2 * out.stride, alive_);
  out.known = true;
}

}  // namespace forefeel
