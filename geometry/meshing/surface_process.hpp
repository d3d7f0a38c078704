#pragma once
// Steps of tetrahedralise() on repaired surfaces (closed, manifold, outward).

#include "geometry/meshing/surface.hpp"

namespace forefeel {

double area(const Surface& surface);  // [m^2]
bool intersects_itself(const Surface& surface);
// A closed surface around everything, offset outward by a twentieth of alpha [m] (CGAL alpha_wrap_3).
Surface alpha_wrap(const Surface& surface, double alpha);
// Triangles of about this edge length [m]: Garland-Heckbert edge collapse while the surface is far finer than that,
// then isotropic remeshing back onto the input; edges sharper than 50 degrees stay.
Surface resample(const Surface& surface, double edge);

}  // namespace forefeel
