#pragma once
// Speeds up queries along a path: it keeps the tetrahedron of states that contained the last place, and its
// affine map. While the path stays inside,
//   lambda_i = (B (q - v_0))_i,  i = 1..3,   lambda_0 = 1 - sum     barycentric weights of q
//   spread   = sqrt(sum lambda_i |v_i - q|^2)
// take a dozen products and no search. The caller owns one walk for each path and thread. A walk may be given to
// any index at any time: if it belongs to another index or is out of date, the query searches and renews it.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "geometry/states/state.hpp"

namespace forefeel {

struct PathWalk {
  std::uint64_t version = 0;   // of the index that it belongs to; 0: of none
  const void* cell = nullptr;  // private to the index
  StateId near;                // where a search starts when the rest is out of date
  bool cached = false;         // true: the fields below belong to the cell
  std::array<StateId, 4> states;
  std::array<Vec3, 4> at;       // [m]
  Mat3 inverse = Mat3::Zero();  // B [1/m]

  void keep(const std::array<Vec3, 4>& corners) {
    at = corners;
    const Vec3 a = at[1] - at[0], b = at[2] - at[0], c = at[3] - at[0];
    const Vec3 bc = b.cross(c);
    const double volume = a.dot(bc);
    const double longest = std::max({a.squaredNorm(), b.squaredNorm(), c.squaredNorm()});
    // The map of a flat cell would be inexact. It is not kept, so every query there searches.
    cached = std::abs(volume) > 1e-3 * longest * std::sqrt(longest);
    if (!cached) return;
    inverse.row(0) = bc / volume;
    inverse.row(1) = c.cross(a) / volume;
    inverse.row(2) = a.cross(b) / volume;
  }

  // True if q lies inside by more than rounding; then `weight` holds its barycentric weights.
  bool holds(const Vec3& q, std::array<double, 4>& weight) const {
    if (!cached) return false;
    const Vec3 w = inverse * (q - at[0]);
    weight = {1 - w.sum(), w[0], w[1], w[2]};
    constexpr double inside = 1e-9;
    return weight[0] > inside && weight[1] > inside && weight[2] > inside && weight[3] > inside;
  }
};

// A new version number for an index; no two calls return the same number.
std::uint64_t next_version();

}  // namespace forefeel
