#pragma once
// The body with each tetrahedron split into eight at the middles of its edges. Its shape stays the same: edges
// are straight. The middle of two nodes of clamp or contact belongs to it too, as a mid-edge node of quadratic
// elements does.

#include <cstdint>

#include "solver/body/body.hpp"

namespace forefeel {

// The nodes come first, in their order; tetrahedron t becomes 8 t to 8 t + 7. Node and element groups of the
// mesh are left out.
Body refined(const Body& body);

// Nodes of its elements, mid-edge nodes of quadratic ones included, by Euler's formula of a ball with few
// nodes on the surface: E = V + T edges, F = 2 T faces. A few per cent below the true number.
std::int64_t estimated_nodes(const Body& body);
std::int64_t estimated_nodes_refined(const Body& body);  // of refined(body)

}  // namespace forefeel
