#pragma once
// What the sums over sites share: turns between two normals, and a cut-off.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "geometry/common/types.hpp"

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

// 1 to 0 over [0, 1], with a continuous second derivative.
inline double fade(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return 1 - t * t * t * (10 + t * (6 * t - 15));
}
inline double fade_slope(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return -30 * t * t * (1 - t) * (1 - t);
}

}  // namespace forefeel
