#pragma once
// A bound of how stiff a body can be at its contact, at rest [N/m]:
//   K_b = sum over tetrahedra of V ((lambda + mu) g g^T + mu |g|^2 I),   g = sum over contact nodes a of grad N_a
// V [m^3]: volume, lambda, mu [Pa]: Lame's constants, N_a: shape function of node a. It is the stiffness of the body
// whose nodes are all held but those of the contact, which move by the same x. The equilibrium has the least energy of
// all displacements with the same contact and clamp, so x^T K x <= x^T K_b x for the stiffness K at rest, of every law
// and of both elements. Equality where no node is free. Meshes of 1,000 elements and more: |K_b| is 2 to 20 |K|.

#include "geometry/common/types.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

Mat3 contact_stiffness_bound(const Body& body);

}  // namespace forefeel
