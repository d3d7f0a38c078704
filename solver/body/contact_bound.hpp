#pragma once
// An upper bound of the stiffness of a body at its contact, at rest [N/m]:
//   K_b = sum over tetrahedra of V ((lambda + mu) g g^T + mu |g|^2 I),   g = sum over contact nodes a of grad N_a
// V [m^3]: volume, lambda, mu [Pa]: Lame's constants, N_a: shape function of node a. K_b is the stiffness if all free
// nodes are held and only the contact nodes move, all by x. The equilibrium has the least energy of all displacements
// with the same contact and clamp, so x^T K x <= x^T K_b x for the stiffness K at rest, for every law and both kinds of
// elements. Both are equal if no node is free. Behind a pad all nodes of the mesh are held: K_b = int a dA I (pad.hpp).
// In meshes of 1,000 elements and more |K_b| is 2 to 20 |K|.

#include "geometry/common/types.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

Mat3 contact_stiffness_bound(const Body& body);

}  // namespace forefeel
