#pragma once
// Regions by sampling: labels at the centres of voxels of h/4, for indexes that cannot prove more. The result has the
// same form as that of Regions; the cost is one query a voxel.

#include <functional>

#include "geometry/coverage/regions.hpp"

namespace forefeel {

// label must be safe to call from several threads at once; rim: how far from a gap its safe neighbours may lie
// (rim_reach() of bridge.hpp) [m]. InputError beyond 4e8 voxels.
RegionSummary sample_regions(const Box& box, double spacing, double rim,
                             const std::function<Label(const Vec3&)>& label);

}  // namespace forefeel
