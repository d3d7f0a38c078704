#pragma once
// Small types that every folder uses. SI units: lengths in m, forces in N.

#include <Eigen/Core>
#include <cstdint>

namespace forefeel {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;  // column-major in memory; every file format writes it row by row

enum class Axis : std::uint8_t { x, y, z };

// A point of a body's surface at rest; the facet is its number in SurfaceMap::facets() (solver/jet/surface_map.hpp).
struct SurfacePlace {
  std::int32_t facet = -1;    // -1: no place
  Vec3 at = Vec3::Zero();     // [m]
  Vec3 share = Vec3::Zero();  // where on its facet, barycentric; zero: to be found from `at`

  bool exists() const { return facet >= 0; }
  friend bool operator==(const SurfacePlace& a, const SurfacePlace& b) {
    return a.facet == b.facet && a.at == b.at;
  }
};

// Axis-aligned box, low <= high per axis [m].
struct Box {
  Vec3 low = Vec3::Zero();
  Vec3 high = Vec3::Zero();

  bool contains(const Vec3& q) const {
    return (q.array() >= low.array()).all() && (q.array() <= high.array()).all();
  }
  Vec3 size() const { return high - low; }
  Vec3 centre() const { return 0.5 * (low + high); }
};

}  // namespace forefeel
