#pragma once
// What the sums over sites share: turns between two normals, a cut-off, and the gradients of barycentric coordinates.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "solver/jet/surface_map.hpp"

namespace forefeel {

inline Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// The least turn that takes n to m, both of length 1, not opposite.
inline Mat3 least_turn(const Vec3& n, const Vec3& m) {
  const Mat3 v = cross_matrix(n.cross(m));
  return Mat3::Identity() + v + v * v / (1 + n.dot(m));
}

// Its derivative where n changes by dn.
inline Mat3 least_turn_by(const Vec3& n, const Vec3& m, const Vec3& dn) {
  const Mat3 v = cross_matrix(n.cross(m)), dv = cross_matrix(dn.cross(m));
  const double c = 1 + n.dot(m);
  return dv + (dv * v + v * dv) / c - v * v * (dn.dot(m) / (c * c));
}

// The same turn of single vectors, without its matrix.
class LeastTurn {
 public:
  LeastTurn() = default;
  LeastTurn(const Vec3& n, const Vec3& m) : m_(m), v_(n.cross(m)), over_(1 / (1 + n.dot(m))) {}
  Vec3 of(const Vec3& u) const {  // Q u
    const Vec3 once = v_.cross(u);
    return u + once + over_ * v_.cross(once);
  }
  Vec3 back(const Vec3& p) const {  // Q^T p
    const Vec3 once = v_.cross(p);
    return p - once + over_ * v_.cross(once);
  }
  Vec3 by_normal(const Vec3& p, const Vec3& u) const {  // d(p . Q u)/dn
    const Vec3 once = v_.cross(u);
    const Vec3 by_v = u.cross(p) + over_ * (once.cross(p) + u.cross(p.cross(v_)));
    return m_.cross(by_v) - over_ * over_ * p.dot(v_.cross(once)) * m_;
  }

 private:
  Vec3 m_ = Vec3::Zero(), v_ = Vec3::Zero();
  double over_ = 0;
};

// 1 to 0 over [0, 1], with a continuous second derivative.
inline double fade(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return 1 - t * t * t * (10 + t * (6 * t - 15));
}
inline double fade_slope(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return -30 * t * t * (1 - t) * (1 - t);
}

// Of the three barycentric coordinates in a facet's plane [1/m].
inline std::array<Vec3, 3> barycentric_slopes(const SurfaceMap& map, std::int32_t facet) {
  const auto [a, b, c] = map.corners(facet);
  const Vec3& n = map.facets()[static_cast<std::size_t>(facet)].normal;
  const double twice = n.dot((b - a).cross(c - a));
  return {Vec3(n.cross(c - b) / twice), Vec3(n.cross(a - c) / twice), Vec3(n.cross(b - a) / twice)};
}

}  // namespace forefeel
