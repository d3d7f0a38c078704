// Computes the coefficients from the factor, and writes the model.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "approx/loops/kernel_sums.hpp"
#include "approx/model/rbf_fit.hpp"

namespace forefeel {
using namespace detail;

// Minimises |Y_P c - Y_f| by modified Gram-Schmidt on [Y_P Y_f], whose last columns become the residual; then
// lambda = L^-T residual. P^T lambda = 0 holds as exactly as the residual is orthogonal to Y_P.
void RbfFit::solve() {
  const std::size_t m = factor_.rows(), q = rows_.terms;
  dense::loops().columns_of(factor_.border_row(0), m, q + 3, rows_.orthogonal.data(), rows_.stride);
  double right[3 * max_terms];
  dense::loops().orthogonalise(q, m, rows_.orthogonal.data(), rows_.stride, solution_.upper, right);
  double value[max_terms][4] = {};  // of three components, and a zero
  for (std::size_t j = 0; j < q; ++j)
    for (std::size_t c = 0; c < 3; ++c) value[j][c] = right[c * q + j];
  for (std::size_t j = q; j-- > 0;) {
    const double inverse = 1 / solution_.upper[j * q + j];
    for (double& v : value[j]) v *= inverse;
    for (std::size_t k = 0; k < j; ++k)
      for (std::size_t c = 0; c < 4; ++c) value[k][c] -= solution_.upper[k * q + j] * value[j][c];
    for (std::size_t c = 0; c < 3; ++c) solution_.coefficient[c][j] = value[j][c];
  }
  double* residual = rows_.orthogonal.data() + q * rows_.stride;
  factor_.solve_transposed(residual, residual + rows_.stride, residual + 2 * rows_.stride);
}

// From the projected kernel back to phi: only the polynomial changes, by -s sum_b lambda_b v_b.
// False if the factor has lost too many digits.
bool RbfFit::write_sum(ModelData& out) {
  solve();
  const std::size_t m = factor_.rows();
  double* all = rows_.orthogonal.data() + rows_.terms * rows_.stride;
  for (std::size_t c = 0; c < 3; ++c) std::fill_n(all + c * rows_.stride + m, 8, 0.0);
  double sums[3 * max_terms];
  dense::loops().dots3(rows_.terms, m, all, rows_.dual.data(), rows_.stride, sums);
  for (std::size_t c = 0; c < 3; ++c) {
    double values[max_terms];
    for (std::size_t j = 0; j < rows_.terms; ++j)
      values[j] = solution_.coefficient[c][j] - rows_.sign * sums[c * rows_.terms + j];
    double monomials[max_terms];
    to_monomials(level_.degree, values, monomials);
    for (std::size_t t = 0; t < max_terms; ++t) out.sum.polynomial[t][c] = monomials[t];
  }
  std::size_t n = 0;
  const std::size_t stride = out.sum.stride, b = rows_.per_slot;
  set_.living.clear();
  for (std::size_t s = 0; s < set_.slots; ++s) {
    if (!set_.slot[s].alive) continue;
    double* to = out.sum.data.data() + n;
    to[0] = set_.px[s];
    to[stride] = set_.py[s];
    to[2 * stride] = set_.pz[s];
    for (std::size_t c = 0; c < 3; ++c) {
      const double* lambda = rows_.orthogonal.data() + (rows_.terms + c) * rows_.stride + s * b;
      to[(3 + c) * stride] = rows_.sign * lambda[0];
      if (b == 4)
        for (std::size_t d = 0; d < 3; ++d) to[(6 + 3 * c + d) * stride] = rows_.sign * lambda[1 + d];
    }
    set_.living.push_back(static_cast<std::uint32_t>(s));
    ++n;
  }
  out.sum.padded = (n + 7) / 8 * 8;
  for (std::size_t a = 0; a < (b == 4 ? 15u : 6u); ++a)
    std::fill(out.sum.data.data() + a * stride + n, out.sum.data.data() + a * stride + out.sum.padded, 0.0);
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
  for (std::size_t s = 0; s < set_.slots; ++s)
    largest = std::max(largest, set_.array(Slots::share)[s] * set_.array(Slots::stiffness_norm)[s]);
  if (largest == 0) {
    Vec3 at = Vec3::Zero(), mean = Vec3::Zero();  // position, force
    double total = 0, squared = 0;
    for (std::size_t s = 0; s < set_.slots; ++s) {
      const double w = set_.array(Slots::share)[s];
      if (!(w > 0)) continue;
      const Vec3 apart = set_.slot[s].sample.at - scaling_.centre;
      total += w;
      at += w * apart;
      mean += w * set_.slot[s].sample.force;
      squared += w * apart.squaredNorm();
    }
    at /= total;
    mean /= total;
    const double least = 0.5 * std::sqrt(std::max(0.0, squared / total - at.squaredNorm()));
    for (std::size_t s = 0; s < set_.slots; ++s) {
      const double w = set_.array(Slots::share)[s],
                   apart = std::max(least, (set_.slot[s].sample.at - scaling_.centre - at).norm());
      if (w > 0 && apart > 0)
        largest = std::max(largest, 2 * w * (set_.slot[s].sample.force - mean).norm() / apart);
    }
  }
  out.largest_stiffness = largest;
  out.bound = (largest_of(set_.array(Slots::force_norm), set_.slots) + largest * out.tangent.hold) /
              ModelData::full_share;
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

// Distances and extent of the set as seen from y (scaled). Fills set_.array(Slots::away) with the distances.
RbfFit::Reach RbfFit::reach_from(const Vec3& y) {
  const sums::Loops& loops = sums::loops();
  double extent[5], distances[2];
  if (set_.weighted) {
    std::fill_n(set_.array(Slots::away), set_.stride, 0.0);
    for (std::size_t s = 0; s < set_.slots; ++s)
      if (set_.slot[s].alive) set_.array(Slots::away)[s] = set_.slot[s].sample.near;
  }
  loops.extent(set_.slots, set_.px.data(), set_.py.data(), set_.pz.data(),
               set_.array(set_.weighted ? Slots::away : Slots::share), extent);
  loops.distances(set_.slots, set_.px.data(), set_.py.data(), set_.pz.data(), set_.array(Slots::in_use),
                  y.data(), set_.array(Slots::away), distances);
  Reach reach{.nearest = distances[0], .farthest = distances[1]};
  double total = double(set_.alive);
  while (reach.first + 1 < set_.slots && (set_.array(Slots::in_use)[reach.first] == 0 ||
                                          set_.array(Slots::away)[reach.first] > reach.nearest))
    ++reach.first;
  if (set_.weighted) {  // the nearest and the farthest as far as they count
    double counted = 0, mean_away = 0;
    total = 0;
    for (std::size_t s = 0; s < set_.slots; ++s) {
      total += set_.slot[s].alive ? set_.slot[s].sample.near : 0;
      counted += set_.array(Slots::share)[s];
      mean_away += set_.array(Slots::share)[s] * set_.array(Slots::away)[s];
    }
    reach.nearest = mean_away /= counted;
    for (std::size_t s = 0; s < set_.slots; ++s)
      reach.nearest = std::min(
          reach.nearest, mean_away - set_.array(Slots::share)[s] * (mean_away - set_.array(Slots::away)[s]));
    reach.farthest = reach.nearest;
    for (std::size_t s = 0; s < set_.slots; ++s)
      reach.farthest =
          std::max(reach.farthest, reach.nearest + set_.array(Slots::share)[s] *
                                                       (set_.array(Slots::away)[s] - reach.nearest));
  }
  // States about equally far count about equally, so that the tangent does not change at once when another
  // state becomes the nearest.
  reach.farthest = std::max(reach.farthest, reach.nearest + options_.length * scaling_.inverse_scale);
  reach.mean = Vec3(extent[0], extent[1], extent[2]) / total;
  reach.radius =
      std::sqrt(std::max(0.0, extent[3] / total - (set_.weighted ? reach.mean.squaredNorm() : 0))) *
      scaling_.scale;
  return reach;
}

// Length [m] of which the trust distance is 1.5 times and the hold distance 4 times: the radius of the set,
// or the distance between states if that is more.
double RbfFit::length_of(const Reach& reach, double half_ball) {
  double length = reach.radius;
  if (set_.weighted &&
      half_ball > 0) {  // 0.68 half_ball is the usual spread; at most 1.5 times the spread of counting states
    double counted[5];
    sums::loops().extent(set_.slots, set_.px.data(), set_.py.data(), set_.pz.data(), set_.array(Slots::share),
                         counted);
    const double shares = std::reduce(set_.array(Slots::share), set_.array(Slots::share) + set_.slots);
    const Vec3 middle = Vec3(counted[0], counted[1], counted[2]) / shares;
    const double spread =
        std::sqrt(std::max(0.0, counted[3] / shares - middle.squaredNorm())) * scaling_.scale;
    length = std::min(0.68 * half_ball, 1.5 * spread);
  }
  const Sample& base = set_.slot[reach.first].sample;
  length = std::max(length, options_.length);
  if (length == 0 && base.stiffness.norm() > 0) length = base.force.norm() / base.stiffness.norm();
  if (!(length > 0)) length = base.at.norm() > 0 ? 0.25 * base.at.norm() : 0.005;
  return length;
}

// Bound, hulls and tangent (see model_data.hpp). A state's share of the tangent falls to zero with its weight
// and towards the farthest state, so that the tangent changes gradually as the set does.
void RbfFit::write_tangent(ModelData& out, const Vec3& hip, double bridge, double half_ball) {
  const Vec3 y = within_range(scaling_.scaled(hip));
  const Reach reach = reach_from(y);
  const double length = length_of(reach, half_ball);
  out.domain.trust = 1.5 * length * scaling_.inverse_scale;
  out.tangent.hold = 4 * length;
  set_bound(out);
  out.domain.bridge = bridge;
  if (out.sum.power != 0) write_hull(out, out.domain.hull, true, reach.mean);
  out.domain.quick = out.sum.power != 0 && bridge == 0 ? out.domain.hull.inner_squared : -1;
  if (out.sum.power != 0 && bridge > 0) write_hull(out, out.domain.whole, false, y);

  bool known = true;
  for (std::size_t s = 0; s < set_.slots && known; ++s)
    known = set_.array(Slots::stiffness_norm)[s] > 0 || set_.array(Slots::in_use)[s] == 0 ||
            (set_.array(Slots::away)[s] >= reach.farthest && s != reach.first);
  if (known)
    write_mean_tangent(out, reach);
  else
    write_tangent_of_sum(out, hip, reach.first, reach.nearest, reach.farthest);
}

// Tangent if every stiffness is known: the mean of f_i - K_i (x - x_i) over the states, about their mean
// position.
void RbfFit::write_mean_tangent(ModelData& out, const Reach& reach) {
  const Sample& base = set_.slot[reach.first].sample;
  const double origin[3] = {set_.px[reach.first], set_.py[reach.first], set_.pz[reach.first]};
  double sum[19];
  sums::loops().tangent(set_.slots, set_.px.data(), set_.py.data(), set_.pz.data(), set_.array(Slots::share),
                        set_.data.data(), set_.stride, set_.array(Slots::away), reach.nearest, reach.farthest,
                        origin, sum);
  if (!(sum[0] > 0)) {  // one state, or all equally far
    out.tangent.at = base.at;
    out.tangent.force = base.force;
    out.tangent.jacobian = -base.stiffness;
    return;
  }
  const double w = 1 / sum[0];
  const Vec3 at = w * scaling_.scale * Vec3(sum[1], sum[2], sum[3]);
  for (int c = 0; c < 3; ++c) {
    out.tangent.force[c] = w * (sum[4 + c] + scaling_.scale * sum[16 + c]);
    for (int d = 0; d < 3; ++d) out.tangent.jacobian(c, d) = -w * sum[7 + 3 * c + d];
  }
  out.tangent.at = base.at + at;
  out.tangent.force += out.tangent.jacobian * at;
}

// The planes that bound the states. Nearer side only: each state is moved towards the mean as its weight falls. Both
// sides: each state is moved towards the HIP, which lies between the sides even if the weight of the far side is small.
void RbfFit::write_hull(const ModelData& out, ModelData::Hull& hull, bool near, const Vec3& centre) {
  if (!set_.weighted) {
    const double* y = out.sum.data.data();
    return hull.set(y, y + out.sum.stride, y + 2 * out.sum.stride, set_.alive, out.domain.trust);
  }
  double* to[3] = {scratch_.hull.data(), scratch_.hull.data() + set_.stride,
                   scratch_.hull.data() + 2 * set_.stride};
  const double* from[3] = {set_.px.data(), set_.py.data(), set_.pz.data()};
  Vec3 middle = centre;
  if (near) {
    double total = 0;
    middle.setZero();
    for (std::size_t s = 0; s < set_.slots; ++s) {
      if (!set_.slot[s].alive) continue;
      total += set_.slot[s].sample.near;
      for (std::size_t d = 0; d < 3; ++d) middle[Eigen::Index(d)] += set_.slot[s].sample.near * from[d][s];
    }
    middle = total > 0 ? Vec3(middle / total) : centre;
  }
  std::size_t n = 0;
  if (!near) {  // the HIP itself belongs to the hull
    for (std::size_t d = 0; d < 3; ++d) to[d][n] = middle[Eigen::Index(d)];
    ++n;
  }
  for (std::size_t s = 0; s < set_.slots; ++s) {
    if (!set_.slot[s].alive) continue;
    const double w = near ? set_.slot[s].sample.near : set_.array(Slots::share)[s];
    for (std::size_t d = 0; d < 3; ++d) to[d][n] = w * from[d][s] + (1 - w) * middle[Eigen::Index(d)];
    ++n;
  }
  hull.set(to[0], to[1], to[2], n, out.domain.trust);
}

// Tangent if not every stiffness is known: the force of the nearest state and the slope of the sum there,
// limited to the largest known stiffness. If the HIP is outside the hull: the mean over the states about as
// near as the nearest.
void RbfFit::write_tangent_of_sum(ModelData& out, const Vec3& hip, std::size_t first, double nearest,
                                  double farthest) {
  const Sample& base = set_.slot[first].sample;
  out.tangent.at = base.at;
  out.tangent.force = base.force;
  out.tangent.jacobian.setZero();
  if (out.sum.power == 0) return;
  const Vec3 y = scaling_.scaled(hip);
  double gradient[3];
  const bool outside = y.allFinite() && out.domain.hull.outside(y.data(), gradient) > 0;
  const double behind = std::min(farthest - nearest, 1.5 * options_.length * scaling_.inverse_scale);
  double total = 0;
  Vec3 at = Vec3::Zero(), sum = Vec3::Zero();  // about the base
  Mat3 jacobian = Mat3::Zero();
  for (std::size_t s = 0; s < set_.slots; ++s) {
    if (!set_.slot[s].alive || (!outside && s != first)) continue;
    const double near = outside && behind > 0 ? 1 - (set_.array(Slots::away)[s] - nearest) / behind
                        : s == first          ? 1
                                              : 0;
    if (!(near > 0)) continue;
    const double share_of = near * near * set_.array(Slots::share)[s];
    const Mat3 slope = slope_of_sum(out, set_.slot[s].sample.at);
    const Vec3 apart = set_.slot[s].sample.at - base.at;
    total += share_of;
    at += share_of * apart;
    jacobian += share_of * slope;
    sum += share_of * (set_.slot[s].sample.force - slope * apart);
  }
  if (!(total > 0)) return;
  at /= total;
  out.tangent.at = base.at + at;
  out.tangent.jacobian = jacobian / total;
  out.tangent.force = sum / total + out.tangent.jacobian * at;
}

Mat3 RbfFit::slope_of_sum(const ModelData& out, const Vec3& at) const {
  const Vec3 y = scaling_.scaled(at);
  double f[3], j[9];
  Mat3 slope;
  out.sum.raw(y.data(), f, j);
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) slope(c, d) = j[3 * c + d] * scaling_.inverse_scale;
  const double norm = slope.norm();
  if (!std::isfinite(norm)) return Mat3::Zero();
  return norm > out.largest_stiffness ? Mat3(slope * (out.largest_stiffness / norm)) : slope;
}

void RbfFit::write(ModelData& out, const Vec3& hip, double bridge, double half_ball) {
  out.clear();
  if (set_.alive == 0) return;
  out.reserve(set_.alive, level_.hermite);
  std::size_t carrying = 0;
  for (std::size_t s = 0; s < set_.slots; ++s) {
    if (!set_.slot[s].alive) continue;
    if (set_.slot[s].sample.state) out.states.push_back(set_.slot[s].sample.id);
    if ((set_.slot[s].dropped & 1u) == 0) ++carrying;
  }
  out.sum.centre = scaling_.centre;
  out.sum.scale = scaling_.scale;
  out.sum.inverse_scale = scaling_.inverse_scale;
  out.sum.degree = level_.degree;
  out.sum.hermite = level_.hermite;
  out.sum.kernel = level_.power == 1 ? Kernel::linear : level_.power == 3 ? Kernel::cubic : Kernel::quintic;
  out.sum.power = carrying > 1 ? level_.power : 0;
  if (out.sum.power != 0 && !write_sum(out) && wear_.updated) {
    gather();
    scratch_.added.assign(scratch_.gathered.begin(), scratch_.gathered.end());
    refit(scratch_.added);
    return write(out, hip, bridge, half_ball);
  }
  write_tangent(out, hip, bridge, half_ball);
  out.known = true;
  out.prepare();
}

}  // namespace forefeel
