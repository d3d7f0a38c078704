#include "geometry/index/local_spread.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace forefeel {
namespace {

constexpr double far_away = 16;            // of the artificial corners, in scales
constexpr double penalty = 1e8;            // their squared distance: larger than that of any state
constexpr double flat_tetrahedron = 1e-7;  // relative height of tetrahedra that count as coplanar
constexpr std::uint32_t artificial = 0xfffffffcu;

// Corners v (in scales) and costs of a tetrahedron around the origin, with the inverse of its edges from v_0.
struct Basis {
  std::array<Vec3, 4> at;
  std::array<double, 4> cost;
  std::array<std::uint32_t, 4> corner;
  std::array<double, 4> weight;  // of the origin, >= 0
  Mat3 inverse;
  double volume = 0;

  void factor() {
    const Vec3 a = at[1] - at[0], b = at[2] - at[0], c = at[3] - at[0];
    const Vec3 bc = b.cross(c);
    volume = a.dot(bc);
    inverse.row(0) = bc / volume;
    inverse.row(1) = c.cross(a) / volume;
    inverse.row(2) = a.cross(b) / volume;
  }
  std::array<double, 4> coordinates(const Vec3& p) const {
    const Vec3 w = inverse * (p - at[0]);
    return {1 - w.sum(), w[0], w[1], w[2]};
  }
  bool real() const {
    return corner[0] < artificial && corner[1] < artificial && corner[2] < artificial &&
           corner[3] < artificial;
  }
};

Basis start() {
  Basis basis;
  constexpr double t = far_away;
  basis.at = {Vec3(t, t, t), Vec3(t, -t, -t), Vec3(-t, t, -t), Vec3(-t, -t, t)};
  basis.cost.fill(penalty);
  basis.corner = {artificial, artificial + 1, artificial + 2, artificial + 3};
  basis.weight.fill(0.25);
  basis.factor();
  return basis;
}

// Replaces the corner whose weight falls to zero first by `p`; false if the tetrahedron would become flat_tetrahedron.
bool pivot(Basis& basis, const Vec3& p, double cost, std::uint32_t index) {
  const std::array<double, 4> share = basis.coordinates(p);
  std::size_t out = 4;
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 4; ++i) {
    if (share[i] <= 1e-10) continue;
    const double ratio = basis.weight[i] / share[i];
    // In a tie an artificial corner leaves; otherwise the one whose removal leaves the largest volume.
    const bool better =
        ratio < step - 1e-13 || (out < 4 && ratio < step + 1e-13 && basis.corner[out] < artificial &&
                                 (basis.corner[i] >= artificial || share[i] > share[out]));
    if (better) step = std::min(step, ratio), out = i;
  }
  if (out == 4) return false;
  const Basis before = basis;
  basis.at[out] = p;
  basis.cost[out] = cost;
  basis.corner[out] = index;
  basis.factor();
  if (!(std::abs(basis.volume) > 1e-13)) {
    basis = before;
    return false;
  }
  basis.weight = basis.coordinates(Vec3::Zero());
  for (double& w : basis.weight) w = std::max(w, 0.0);
  return true;
}

}  // namespace

LocalSpread least_spread(std::span<const Vec3> offsets, double scale) {
  LocalSpread result;
  if (offsets.size() < 4) return result;
  Basis basis = start();
  const double unit = 1 / scale;
  for (int round = 0; round < 200; ++round) {
    // Dual: the plane t + g . r through the lifted corners; a state below it enters.
    const Vec3 g =
        basis.inverse.transpose() *
        Vec3(basis.cost[1] - basis.cost[0], basis.cost[2] - basis.cost[0], basis.cost[3] - basis.cost[0]);
    const double t = basis.cost[0] - g.dot(basis.at[0]);
    const Vec3 slope = g * unit;
    double lowest = basis.real() ? -1e-11 * (1 + std::abs(t)) : -1e-6;
    std::size_t enter = offsets.size();
    for (std::size_t j = 0; j < offsets.size(); ++j) {
      const double reduced = offsets[j].squaredNorm() * unit * unit - t - slope.dot(offsets[j]);
      if (reduced < lowest) lowest = reduced, enter = j;
    }
    if (enter == offsets.size()) break;
    const Vec3 p = offsets[enter] * unit;
    if (!pivot(basis, p, p.squaredNorm(), static_cast<std::uint32_t>(enter))) break;
  }
  double sum = 0, strange = 0, longest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (basis.corner[i] >= artificial) {
      strange += basis.weight[i];
      continue;
    }
    sum += basis.weight[i] * basis.cost[i];
    longest = std::max(longest, (basis.at[i] - basis.at[0]).norm());
  }
  if (strange > 1e-9) return result;
  result.spread = std::sqrt(sum) * scale;
  result.solid = basis.real() && std::abs(basis.volume) > flat_tetrahedron * longest * longest * longest;
  result.corner = basis.corner;
  return result;
}

double circumradius(const std::array<Vec3, 4>& corner) {
  const Vec3 a = corner[1] - corner[0], b = corner[2] - corner[0], c = corner[3] - corner[0];
  return (a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a) + c.squaredNorm() * a.cross(b)).norm() /
         (2 * std::abs(a.dot(b.cross(c))));
}

}  // namespace forefeel
