#pragma once
// Estimates the contact stiffness at rest without a solve. The contact patch is modelled as a rigid disc of the same
// area A [m^2], bonded to an elastic half-space of the material at the patch:
//   a = sqrt(A / pi)   k_n = 4 G a ln(3 - 4 nu) / (1 - 2 nu)   k_t = 8 G a / (2 - nu)   G = E / (2 (1 + nu))
//   K = k_t I + (k_n - k_t) n n^T
// E [Pa], nu: elastic constants; a [m]: radius; k_n, k_t, K [N/m]; n: mean outward normal of the patch.
// k_n is exact for the bonded disc (Muskhelishvili; K. L. Johnson, Contact Mechanics, 1985, ch. 3). k_t
// is that of R. D. Mindlin, J. Appl. Mech. 16, 1949, which neglects the small coupling of shift and tilt. This is only
// a first guess: a real body is stiffer where it is thin above its clamp, and softer where it is slender.

#include <optional>

#include "geometry/common/types.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// Behind a pad of radius r (pad.hpp) the disc has a = 0.6523 r, and its springs stand in series: K = (K^-1 + I / k)^-1,
// k = int a dA.

// Area of the patch [m^2]; of a pad that of the surface under it. The true area of a coarse patch lies between the area
// of the triangles within it and the area that belongs to its nodes (a third of each triangle at a node); this is the
// mean of the two.
double contact_area(const Body& body);

// The material of all tetrahedra within 2 a of the patch, where most of the disc's compliance arises. nullopt if
// there are several materials.
std::optional<Material> patch_material(const Body& body);

// K [N/m], symmetric, positive definite. Zero if no contact node belongs to a triangle of the surface, or if
// patch_material() finds several materials.
Mat3 disc_stiffness(const Body& body);

// An upper bound of the stiffness of a body at its contact, at rest [N/m]:
//   K_b = sum over tetrahedra of V ((lambda + mu) g g^T + mu |g|^2 I),   g = sum over contact nodes a of grad N_a
// V [m^3]: volume, lambda, mu [Pa]: Lame's constants, N_a: shape function of node a. K_b is the stiffness if all free
// nodes are held and only the contact nodes move, all by x. The equilibrium has the least energy of all displacements
// with the same contact and clamp, so x^T K x <= x^T K_b x for the stiffness K at rest, for every law and both kinds of
// elements. Both are equal if no node is free. Behind a pad all nodes of the mesh are held: K_b = int a dA I (pad.hpp).
// In meshes of 1,000 elements and more |K_b| is 2 to 20 |K|.

Mat3 contact_stiffness_bound(const Body& body);

}  // namespace forefeel
