#pragma once
// Regions by sampling: labels at the centres of voxels of side h/4, for indexes that cannot prove labels for
// larger cells. The result has the form of Regions::summary(); the cost is one query for each voxel.

#include <functional>

#include "geometry/coverage/region_summary.hpp"

namespace forefeel {

// label: called by several threads at once. rim: rim_reach() of bridge.hpp, how far from a gap its safe
// neighbours may lie [m]. InputError beyond 4e8 voxels.
RegionSummary sample_regions(const Box& box, double spacing, double rim,
                             const std::function<Label(const Vec3&)>& label);

}  // namespace forefeel
