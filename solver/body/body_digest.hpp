#pragma once
// The identity of a body, stored with its states and caches. Two bodies with the same identity have the same
// equilibria.

#include "geometry/states/state_header.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// Keys: "mesh" (positions and tetrahedra), "clamp" and "contact" as SHA-256; "element" and "material" in words. Several
// materials come with the SHA-256 of their tetrahedra. Node positions count to the last bit.
BodyIdentity identity_of(const Body& body);

}  // namespace forefeel
