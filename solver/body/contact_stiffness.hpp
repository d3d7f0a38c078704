#pragma once
// The stiffness at rest without a solve: the contact patch as a rigid disc of the same area A, bonded to an elastic
// half-space of the body's material,
//   a = sqrt(A / pi)     k_n = 4 G a ln(3 - 4 nu) / (1 - 2 nu)     k_t = 8 G a / (2 - nu)     G = E / (2 (1 + nu))
//   K = k_t I + (k_n - k_t) n n^T
// with n the mean normal of the patch. k_n is exact for the bonded disc (Muskhelishvili; K. L. Johnson, Contact Mechanics,
// 1985, eq. 3.105), k_t that of R. D. Mindlin, J. Appl. Mech. 16, 1949, which leaves the small coupling of shift and tilt out.
// A body is no half-space: where it is thin above its clamp it is stiffer, where it is slender softer. A first guess.

#include "solver/body/body.hpp"

namespace forefeel {

// Area of the patch [m^2]: the mean of what its triangles cover and what falls to its nodes (a third of each triangle
// at them). Both tend to the patch's own area as the mesh is refined; coarse meshes lie between them.
double contact_area(const Body& body);

// K [N/m], symmetric, positive definite. Zero where the contact nodes bear no triangle of the surface.
Mat3 disc_stiffness(const Body& body);

}  // namespace forefeel
