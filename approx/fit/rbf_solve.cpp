// Computes the coefficients from the factor, and writes the model.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "approx/fit/rbf_fit.hpp"
#include "approx/loops/kernel_sums.hpp"

namespace forefeel {
using namespace detail;

// Minimises |Y_P c - Y_f| by modified Gram-Schmidt on [Y_P Y_f], whose last columns become the residual; then
// lambda = L^-T residual. P^T lambda = 0 holds as exactly as the residual is orthogonal to Y_P.
void RbfFit::solve() {
  const std::size_t m = factor_.rows(), q = terms_;
  dense::loops().columns_of(factor_.border_row(0), m, q + 3, orthogonal_.data(), row_stride_);
  double right[3 * max_terms];
  dense::loops().orthogonalise(q, m, orthogonal_.data(), row_stride_, upper_, right);
  double value[max_terms][4] = {};  // of three components, and a zero
  for (std::size_t j = 0; j < q; ++j)
    for (std::size_t c = 0; c < 3; ++c) value[j][c] = right[c * q + j];
  for (std::size_t j = q; j-- > 0;) {
    const double inverse = 1 / upper_[j * q + j];
    for (double& v : value[j]) v *= inverse;
    for (std::size_t k = 0; k < j; ++k)
      for (std::size_t c = 0; c < 4; ++c) value[k][c] -= upper_[k * q + j] * value[j][c];
    for (std::size_t c = 0; c < 3; ++c) coefficient_[c][j] = value[j][c];
  }
  double* residual = orthogonal_.data() + q * row_stride_;
  factor_.solve_transposed(residual, residual + row_stride_, residual + 2 * row_stride_);
}

// From the projected kernel back to phi: only the polynomial changes, by -s sum_b lambda_b v_b.
// False if the factor has lost too many digits.
bool RbfFit::write_sum(ModelData& out) {
  solve();
  const std::size_t m = factor_.rows();
  double* all = orthogonal_.data() + terms_ * row_stride_;
  for (std::size_t c = 0; c < 3; ++c) std::fill_n(all + c * row_stride_ + m, 8, 0.0);
  double sums[3 * max_terms];
  dense::loops().dots3(terms_, m, all, dual_.data(), row_stride_, sums);
  for (std::size_t c = 0; c < 3; ++c) {
    double values[max_terms];
    for (std::size_t j = 0; j < terms_; ++j) values[j] = coefficient_[c][j] - sign_ * sums[c * terms_ + j];
    double monomials[max_terms];
    to_monomials(level_.degree, values, monomials);
    for (std::size_t t = 0; t < max_terms; ++t) out.polynomial[t][c] = monomials[t];
  }
  std::size_t n = 0;
  const std::size_t stride = out.stride, b = rows_per_slot_;
  living_.clear();
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
    living_.push_back(static_cast<std::uint32_t>(s));
    ++n;
  }
  out.padded = (n + 7) / 8 * 8;
  for (std::size_t a = 0; a < (b == 4 ? 15u : 6u); ++a)
    std::fill(out.data.data() + a * stride + n, out.data.data() + a * stride + out.padded, 0.0);
  return !has_lost_digits(out) || (!refit_is_cheaper() && refine(out));
}

namespace {

double largest_of(const double* values, std::size_t n) {
  double largest = 0;
  for (std::size_t i = 0; i < n; ++i) largest = std::max(largest, values[i]);
  return largest;
}

}  // namespace

// The bound B (model_data.hpp). If no stiffness is known, twice the largest secant from the mean of the
// states replaces K.
void RbfFit::set_bound(ModelData& out) {
  double largest = 0;
  for (std::size_t s = 0; s < slots_; ++s)
    largest = std::max(largest, slot_array(share)[s] * slot_array(stiffness_norm)[s]);
  if (largest == 0) {
    Vec3 at = Vec3::Zero(), mean = Vec3::Zero();  // position, force
    double total = 0, squared = 0;
    for (std::size_t s = 0; s < slots_; ++s) {
      const double w = slot_array(share)[s];
      if (!(w > 0)) continue;
      const Vec3 apart = slot_[s].sample.at - centre_;
      total += w;
      at += w * apart;
      mean += w * slot_[s].sample.force;
      squared += w * apart.squaredNorm();
    }
    at /= total;
    mean /= total;
    const double least = 0.5 * std::sqrt(std::max(0.0, squared / total - at.squaredNorm()));
    for (std::size_t s = 0; s < slots_; ++s) {
      const double w = slot_array(share)[s],
                   apart = std::max(least, (slot_[s].sample.at - centre_ - at).norm());
      if (w > 0 && apart > 0)
        largest = std::max(largest, 2 * w * (slot_[s].sample.force - mean).norm() / apart);
    }
  }
  out.largest_stiffness = largest;
  out.bound = (largest_of(slot_array(force_norm), slots_) + largest * out.hold) / ModelData::full_share;
}

namespace {

// y, limited so that no distance to it overflows; 0 if it is not finite.
Vec3 within_range(Vec3 y) {
  const double distance = y.stableNorm();
  if (distance < 1e8) return y;
  if (std::isfinite(distance))
    y *= 1e8 / distance;
  else
    y.setZero();
  return y;
}

}  // namespace

// Distances and extent of the set as seen from y (scaled). Fills slot_array(away) with the distances.
RbfFit::Reach RbfFit::reach_from(const Vec3& y) {
  const sums::Loops& loops = sums::loops();
  double extent[5], distances[2];
  if (weighted_) {
    std::fill_n(slot_array(away), slot_stride_, 0.0);
    for (std::size_t s = 0; s < slots_; ++s)
      if (slot_[s].alive) slot_array(away)[s] = slot_[s].sample.near;
  }
  loops.extent(slots_, px_.data(), py_.data(), pz_.data(), slot_array(weighted_ ? away : share), extent);
  loops.distances(slots_, px_.data(), py_.data(), pz_.data(), slot_array(in_use), y.data(), slot_array(away),
                  distances);
  Reach reach{.nearest = distances[0], .farthest = distances[1]};
  double total = double(alive_);
  while (reach.first + 1 < slots_ &&
         (slot_array(in_use)[reach.first] == 0 || slot_array(away)[reach.first] > reach.nearest))
    ++reach.first;
  if (weighted_) {  // the nearest and the farthest as far as they count
    double counted = 0, mean_away = 0;
    total = 0;
    for (std::size_t s = 0; s < slots_; ++s) {
      total += slot_[s].alive ? slot_[s].sample.near : 0;
      counted += slot_array(share)[s];
      mean_away += slot_array(share)[s] * slot_array(away)[s];
    }
    reach.nearest = mean_away /= counted;
    for (std::size_t s = 0; s < slots_; ++s)
      reach.nearest =
          std::min(reach.nearest, mean_away - slot_array(share)[s] * (mean_away - slot_array(away)[s]));
    reach.farthest = reach.nearest;
    for (std::size_t s = 0; s < slots_; ++s)
      reach.farthest = std::max(reach.farthest,
                                reach.nearest + slot_array(share)[s] * (slot_array(away)[s] - reach.nearest));
  }
  // States about equally far count about equally, so that the tangent does not change at once when another
  // state becomes the nearest.
  reach.farthest = std::max(reach.farthest, reach.nearest + options_.length * inverse_scale_);
  reach.mean = Vec3(extent[0], extent[1], extent[2]) / total;
  reach.radius =
      std::sqrt(std::max(0.0, extent[3] / total - (weighted_ ? reach.mean.squaredNorm() : 0))) * scale_;
  return reach;
}

// Length [m] of which the trust distance is 1.5 times and the hold distance 4 times: the radius of the set,
// or the distance between states if that is more.
double RbfFit::length_of(const Reach& reach, double half_ball) {
  double length = reach.radius;
  if (weighted_ &&
      half_ball > 0) {  // 0.68 half_ball is the usual spread; at most 1.5 times the spread of counting states
    double counted[5];
    sums::loops().extent(slots_, px_.data(), py_.data(), pz_.data(), slot_array(share), counted);
    const double shares = std::reduce(slot_array(share), slot_array(share) + slots_);
    const Vec3 middle = Vec3(counted[0], counted[1], counted[2]) / shares;
    const double spread = std::sqrt(std::max(0.0, counted[3] / shares - middle.squaredNorm())) * scale_;
    length = std::min(0.68 * half_ball, 1.5 * spread);
  }
  const Sample& base = slot_[reach.first].sample;
  length = std::max(length, options_.length);
  if (length == 0 && base.stiffness.norm() > 0) length = base.force.norm() / base.stiffness.norm();
  if (!(length > 0)) length = base.at.norm() > 0 ? 0.25 * base.at.norm() : 0.005;
  return length;
}

// Bound, hulls and tangent (see model_data.hpp). A state's share of the tangent falls to zero with its weight
// and towards the farthest state, so that the tangent changes gradually as the set does.
void RbfFit::write_tangent(ModelData& out, const Vec3& hip, double bridge, double half_ball) {
  const Vec3 y = within_range(scaled(hip));
  const Reach reach = reach_from(y);
  const double length = length_of(reach, half_ball);
  out.trust = 1.5 * length * inverse_scale_;
  out.hold = 4 * length;
  set_bound(out);
  out.bridge = bridge;
  if (out.power != 0) write_hull(out, out.hull, true, reach.mean);
  out.quick = out.power != 0 && bridge == 0 ? out.hull.inner_squared : -1;
  if (out.power != 0 && bridge > 0) write_hull(out, out.whole, false, y);

  bool known = true;
  for (std::size_t s = 0; s < slots_ && known; ++s)
    known = slot_array(stiffness_norm)[s] > 0 || slot_array(in_use)[s] == 0 ||
            (slot_array(away)[s] >= reach.farthest && s != reach.first);
  if (known)
    write_mean_tangent(out, reach);
  else
    write_tangent_of_sum(out, hip, reach.first, reach.nearest, reach.farthest);
}

// Tangent if every stiffness is known: the mean of f_i - K_i (x - x_i) over the states, about their mean
// position.
void RbfFit::write_mean_tangent(ModelData& out, const Reach& reach) {
  const Sample& base = slot_[reach.first].sample;
  const double origin[3] = {px_[reach.first], py_[reach.first], pz_[reach.first]};
  double sum[19];
  sums::loops().tangent(slots_, px_.data(), py_.data(), pz_.data(), slot_array(share), slot_data_.data(),
                        slot_stride_, slot_array(away), reach.nearest, reach.farthest, origin, sum);
  if (!(sum[0] > 0)) {  // one state, or all equally far
    out.tangent_at = base.at;
    out.tangent_force = base.force;
    out.tangent_jacobian = -base.stiffness;
    return;
  }
  const double w = 1 / sum[0];
  const Vec3 at = w * scale_ * Vec3(sum[1], sum[2], sum[3]);
  for (int c = 0; c < 3; ++c) {
    out.tangent_force[c] = w * (sum[4 + c] + scale_ * sum[16 + c]);
    for (int d = 0; d < 3; ++d) out.tangent_jacobian(c, d) = -w * sum[7 + 3 * c + d];
  }
  out.tangent_at = base.at + at;
  out.tangent_force += out.tangent_jacobian * at;
}

// The planes that bound the states. Nearer side only: each state is moved towards the mean as its weight falls. Both
// sides: each state is moved towards the HIP, which lies between the sides even if the weight of the far side is small.
void RbfFit::write_hull(const ModelData& out, ModelData::Hull& hull, bool near, const Vec3& centre) {
  if (!weighted_) {
    const double* y = out.data.data();
    return hull.set(y, y + out.stride, y + 2 * out.stride, alive_, out.trust);
  }
  double* to[3] = {hull_.data(), hull_.data() + slot_stride_, hull_.data() + 2 * slot_stride_};
  const double* from[3] = {px_.data(), py_.data(), pz_.data()};
  Vec3 middle = centre;
  if (near) {
    double total = 0;
    middle.setZero();
    for (std::size_t s = 0; s < slots_; ++s) {
      if (!slot_[s].alive) continue;
      total += slot_[s].sample.near;
      for (std::size_t d = 0; d < 3; ++d) middle[Eigen::Index(d)] += slot_[s].sample.near * from[d][s];
    }
    middle = total > 0 ? Vec3(middle / total) : centre;
  }
  std::size_t n = 0;
  if (!near) {  // the HIP itself belongs to the hull
    for (std::size_t d = 0; d < 3; ++d) to[d][n] = middle[Eigen::Index(d)];
    ++n;
  }
  for (std::size_t s = 0; s < slots_; ++s) {
    if (!slot_[s].alive) continue;
    const double w = near ? slot_[s].sample.near : slot_array(share)[s];
    for (std::size_t d = 0; d < 3; ++d) to[d][n] = w * from[d][s] + (1 - w) * middle[Eigen::Index(d)];
    ++n;
  }
  hull.set(to[0], to[1], to[2], n, out.trust);
}

// Tangent if not every stiffness is known: the force of the nearest state and the slope of the sum there,
// limited to the largest known stiffness. If the HIP is outside the hull: the mean over the states about as
// near as the nearest.
void RbfFit::write_tangent_of_sum(ModelData& out, const Vec3& hip, std::size_t first, double nearest,
                                  double farthest) {
  const Sample& base = slot_[first].sample;
  out.tangent_at = base.at;
  out.tangent_force = base.force;
  out.tangent_jacobian.setZero();
  if (out.power == 0) return;
  const Vec3 y = scaled(hip);
  double gradient[3];
  const bool outside = y.allFinite() && out.hull.outside(y.data(), gradient) > 0;
  const double behind = std::min(farthest - nearest, 1.5 * options_.length * inverse_scale_);
  double total = 0;
  Vec3 at = Vec3::Zero(), sum = Vec3::Zero();  // about the base
  Mat3 jacobian = Mat3::Zero();
  for (std::size_t s = 0; s < slots_; ++s) {
    if (!slot_[s].alive || (!outside && s != first)) continue;
    const double near = outside && behind > 0 ? 1 - (slot_array(away)[s] - nearest) / behind
                        : s == first          ? 1
                                              : 0;
    if (!(near > 0)) continue;
    const double share_of = near * near * slot_array(share)[s];
    const Mat3 slope = slope_of_sum(out, slot_[s].sample.at);
    const Vec3 apart = slot_[s].sample.at - base.at;
    total += share_of;
    at += share_of * apart;
    jacobian += share_of * slope;
    sum += share_of * (slot_[s].sample.force - slope * apart);
  }
  if (!(total > 0)) return;
  at /= total;
  out.tangent_at = base.at + at;
  out.tangent_jacobian = jacobian / total;
  out.tangent_force = sum / total + out.tangent_jacobian * at;
}

Mat3 RbfFit::slope_of_sum(const ModelData& out, const Vec3& at) const {
  const Vec3 y = scaled(at);
  double f[3], j[9];
  Mat3 slope;
  out.raw(y.data(), f, j);
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) slope(c, d) = j[3 * c + d] * inverse_scale_;
  const double norm = slope.norm();
  if (!std::isfinite(norm)) return Mat3::Zero();
  return norm > out.largest_stiffness ? Mat3(slope * (out.largest_stiffness / norm)) : slope;
}

void RbfFit::write(ModelData& out, const Vec3& hip, double bridge, double half_ball) {
  out.clear();
  if (alive_ == 0) return;
  out.reserve(alive_, level_.hermite);
  std::size_t carrying = 0;
  for (std::size_t s = 0; s < slots_; ++s) {
    if (!slot_[s].alive) continue;
    if (slot_[s].sample.state) out.states.push_back(slot_[s].sample.id);
    if ((slot_[s].dropped & 1u) == 0) ++carrying;
  }
  out.centre = centre_;
  out.scale = scale_;
  out.inverse_scale = inverse_scale_;
  out.degree = level_.degree;
  out.hermite = level_.hermite;
  out.kernel = level_.power == 1 ? Kernel::linear : level_.power == 3 ? Kernel::cubic : Kernel::quintic;
  out.power = carrying > 1 ? level_.power : 0;
  if (out.power != 0 && !write_sum(out) && updated_) {
    gather();
    added_.assign(gathered_.begin(), gathered_.end());
    refit(added_);
    return write(out, hip, bridge, half_ball);
  }
  write_tangent(out, hip, bridge, half_ball);
  out.known = true;
  out.prepare();
}

}  // namespace forefeel
