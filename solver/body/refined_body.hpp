#pragma once
// The body with each tetrahedron split into eight at the midpoints of its edges. Edges stay straight, so the shape is
// the same. The midpoint between two clamped nodes is clamped, and one between two contact nodes belongs to the
// contact, as for the mid-edge nodes of quadratic elements.

#include <cstdint>

#include "solver/body/body.hpp"

namespace forefeel {

// The nodes come first, in their order; tetrahedron t becomes 8 t to 8 t + 7. Node and element groups of the
// mesh are left out.
Body refined(const Body& body);

// Estimated number of nodes of its elements, mid-edge nodes of quadratic ones included; a few per cent too low. Euler's
// formula for a ball with few nodes on the surface gives E = V + T edges and F = 2 T faces.
std::int64_t estimated_nodes(const Body& body);
std::int64_t estimated_nodes_refined(const Body& body);  // of refined(body)

}  // namespace forefeel
