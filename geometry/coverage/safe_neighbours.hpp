#pragma once
// The safe components next to the others: those that share a facet, and for a gap those within the rim (bridge.hpp).

#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/coverage/voxel_runs.hpp"

namespace forefeel {

// Pairs of a component that is not safe and a safe one; some may repeat. rim [m].
std::vector<std::pair<std::uint32_t, std::uint32_t>> safe_neighbours(const VoxelLabels& voxels,
                                                                     const VoxelRuns& runs, double rim);

}  // namespace forefeel
