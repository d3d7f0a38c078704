#pragma once
// The first half of regions.cpp: the voxels (voxels.hpp) that are safe, and sparse ones, block by block.
//
// A block of voxels is triangulated with the states in and around it, labelled, and its triangulation dropped. A cell
// of this triangulation is also a cell of the triangulation of all states if and only if its ball (circumsphere)
// contains no other state. This is certain for a ball inside the box whose states are all included; otherwise it is
// tested. So
//   pi(q) <= kappa_s h here implies the same with all states (the spread never grows when states are added), and
//   pi(q) > kappa_s h in a cell whose ball is empty is final.
// If the states within reach of the cone enclose a place, but its cell is not in the triangulation of all states, the
// states in the ball of the cell are added until it is. No other place can be safe.
// A state whose cells are all certain needs no further triangulation. The caller triangulates the others: those with
// large cells, and those at the hull.

#include <cstdint>
#include <functional>
#include <vector>

#include "geometry/coverage/cell_raster.hpp"
#include "geometry/coverage/region_summary.hpp"

namespace forefeel {

// All states, with an index for distances.
struct CoveredStates {
  std::vector<Vec3> at;  // [m]
  PointOctree points;    // numbers are indices of `at`
  double largest = 0;    // coordinate, without sign [m]
};

struct BlockFindings {
  double fill = 0;  // largest radius of an empty ball with its centre in the box [m]
  // Such balls; of each block from large to small, up to the first whose centre is certainly in the hull of the states.
  std::vector<EmptyBall> balls;
  std::vector<std::uint32_t> open;  // states with a cell that is not certain
};

// Sets the labels safe and sparse; the other voxels stay unset_label. All threads work at once; the results do not
// depend on their number. One thread calls progress with the share done.
BlockFindings label_blocks(const CoveredStates& states, const VoxelLimits& limits, VoxelLabels& voxels,
                           const std::function<void(double)>& progress);

}  // namespace forefeel
