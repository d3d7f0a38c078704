#pragma once
// The last step of a coverage map: sparse, gap or blank for the voxels that are not safe.

#include <span>

#include "geometry/coverage/far_proof.hpp"
#include "geometry/coverage/voxel_labels.hpp"

namespace forefeel {

// Labels every voxel that has mark::unset (cell_raster.hpp). Cubes of voxels that are all far from every state are
// labelled together if a bound proves one label for all of them.
void label_far(const PointOctree& points, std::span<const Vec3> at, const Thresholds& limits,
               VoxelLabels& voxels);

}  // namespace forefeel
