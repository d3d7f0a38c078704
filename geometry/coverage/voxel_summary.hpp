#pragma once
// Regions from the labels of all voxels: the largest cubes of one label, their components and volumes. The form and
// the order are those of Regions::summary().

#include "geometry/coverage/region_summary.hpp"
#include "geometry/coverage/voxel_labels.hpp"

namespace forefeel {

// rim: rim_reach() of bridge.hpp, how far from a gap its safe neighbours may lie [m]. Without leaves, only their
// number is found (leaf_count).
RegionSummary summarise(const VoxelLabels& voxels, double rim, bool with_leaves);

}  // namespace forefeel
