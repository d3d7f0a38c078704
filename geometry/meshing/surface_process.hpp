#pragma once
// Steps of tetrahedralise() by CGAL, for repaired surfaces: closed, manifold, outward. Private to this room.

#include <functional>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

double surface_area(const Surface& surface);  // [m^2]
bool intersects_itself(const Surface& surface);
// A closed surface around the whole input, a twentieth of alpha [m] outside it (CGAL alpha_wrap_3).
Surface alpha_wrap(const Surface& surface, double alpha);
// By edge collapse (Garland and Heckbert 1997), to a share of its edges.
Surface decimated(const Surface& surface, double share);
// The same surface with triangles of about this edge length [m]. A much finer surface is first decimated by
// edge collapse (Garland and Heckbert 1997). Then it is remeshed isotropically and projected onto the input.
// Edges sharper than 50 degrees are kept.
Surface resample_surface(const Surface& surface, double edge);

// The nearest point of a surface, by a tree of its triangles; see nearest_point() in surface.hpp.
struct NearestPoint {
  Vec3 point = Vec3::Zero();  // [m]
  std::size_t triangle = 0;   // of the surface
};

// The surface has at least one triangle that is not flat, and outlives nothing: it is copied.
std::function<NearestPoint(const Vec3&)> nearest_on(const Surface& surface);

}  // namespace forefeel
