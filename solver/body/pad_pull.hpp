#pragma once
// Which share of a pad's springs pulls. A fingertip only pushes; the springs of a pad (pad.hpp) also pull, as if
// bonded:
//   q(y) = a(y) (x - u(y)) . x / |x|     [Pa]
//   pulling share = int max(0, -q) dA / int |q| dA
// a [N/m^3] density of the springs, x [m] position of the tip, u(y) [m] displacement of the surface.

#include <span>

#include "solver/body/body.hpp"

namespace forefeel {

// displacements: of the mesh's nodes, #V x 3 [m]. Midpoint rule over 256 parts of each facet, u linear over a facet.
// 0 without a pad and at rest.
double pulling_share(const Body& body, std::span<const double> displacements, const Vec3& x);

}  // namespace forefeel
