#pragma once
// The nearest point of a surface, by a tree of its triangles. Private to this room; see nearest_point() in surface.hpp.

#include <functional>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct NearestPoint {
  Vec3 point = Vec3::Zero();  // [m]
  std::size_t triangle = 0;   // of the surface
};

// The surface has at least one triangle that is not flat, and outlives nothing: it is copied.
std::function<NearestPoint(const Vec3&)> nearest_on(const Surface& surface);

}  // namespace forefeel
