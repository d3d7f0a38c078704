#pragma once
// Even triangulations of smooth closed surfaces f(x) = 0. A subdivided icosahedron is projected onto the
// surface along rays; then smoothing along the surface alternates with Delaunay flips. Only + - * / and
// square roots are used, so every processor computes the same bits.

#include <functional>
#include <span>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct ImplicitSurface {
  std::function<double(const Vec3&)> value;  // > 0 inside
  std::function<Vec3(const Vec3&)> gradient;
  Vec3 centre;   // the body is star-shaped about it
  double reach;  // no point of the body is farther from centre [m]
};

// The subdivided icosahedron: 20 n^2 triangles, 10 n^2 + 2 nodes on the unit sphere.
Surface geodesic_sphere(int n);

Vec3 project_onto(const ImplicitSurface& body, Vec3 point);  // along the gradient
Vec3 last_crossing(const ImplicitSurface& body, const Vec3& from,
                   const Vec3& direction);  // of the ray with the surface

// 20 n^2 triangles on the surface, outward; each point of `pins` becomes a node.
Surface triangulate_implicit(const ImplicitSurface& body, int n, std::span<const Vec3> pins);

}  // namespace forefeel
