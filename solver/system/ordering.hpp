#pragma once
// The order in which a sparse Cholesky factorisation eliminates the nodes of a graph, chosen for little fill: nested
// dissection of the positions, minimum degree within small parts.

#include <cstdint>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

// adjacency: sorted lists; positions [m] by node. Returns the order: order[i] is the node eliminated i-th.
std::vector<std::uint32_t> elimination_order(const std::vector<std::vector<std::uint32_t>>& adjacency,
                                             const std::vector<Vec3>& positions);

}  // namespace forefeel
