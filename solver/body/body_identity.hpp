#pragma once
// The identity of a body: what its states and its caches are known by. Two bodies with the same identity have the same
// equilibria.

#include "geometry/states/body_identity.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// "mesh" (positions and tetrahedra), "clamp" and "contact" as SHA-256; "element" and "material" in words, of
// several materials with the SHA-256 of their tetrahedra. Node positions count to the last bit.
BodyIdentity identity_of(const Body& body);

}  // namespace forefeel
