#pragma once
// Even triangulations of smooth closed surfaces given as f(x) = 0: a subdivided icosahedron is thrown onto the
// surface along rays, then relaxed by turns of smoothing along the surface and Delaunay flips. Only + - * / and
// square roots are used, so that every processor gets the same bits.

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

Vec3 project(const ImplicitSurface& body, Vec3 point);  // nearest along the gradient
Vec3 cast(const ImplicitSurface& body, const Vec3& from, const Vec3& direction);  // last crossing on the ray

// 20 n^2 triangles on the body, outward; one node comes to lie on each of `pins`.
Surface triangulate(const ImplicitSurface& body, int n, std::span<const Vec3> pins);

}  // namespace forefeel
