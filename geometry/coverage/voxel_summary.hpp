#pragma once
// Regions as plain data, from the labels of all voxels: the largest cubes of one label (leaves), their components and
// volumes. Leaves are cubes of 2^k voxels. Their order, and that of the components, depends on the labels alone.

#include <functional>
#include <utility>
#include <vector>

#include "geometry/coverage/region_summary.hpp"
#include "geometry/coverage/voxel_labels.hpp"
#include "geometry/coverage/voxel_runs.hpp"

namespace forefeel {

// rim: how far from a gap around a place its safe neighbours may lie [m] (rim_reach() of bridge.hpp).
using RimReach = std::function<double(const Vec3&)>;

// Without leaves, only their number is found (leaf_count). The sides of gaps are left to find_sides() of bridge.hpp.
RegionSummary summarise(const VoxelLabels& voxels, const RimReach& rim, bool with_leaves);

// Regions by sampling: a label for the centre of every voxel of side h/4. label: called by several threads at once.
// InputError beyond 4e8 voxels.
RegionSummary sample_regions(const Box& box, double spacing, double rim,
                             const std::function<Label(const Vec3&)>& label);

// Pairs of a component that is not safe and a safe one next to it (RegionComponent::safe_neighbours).
std::vector<std::pair<std::uint32_t, std::uint32_t>> safe_neighbours(const VoxelLabels& voxels,
                                                                     const VoxelRuns& runs,
                                                                     const RimReach& rim);

}  // namespace forefeel
