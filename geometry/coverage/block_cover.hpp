#pragma once
// Labels the voxels of one block from the Delaunay triangulation of the states in and around it.
//
// A cell of this triangulation is also a cell of the triangulation of all states if and only if its ball (circumsphere)
// contains no other state. This is certain for a ball inside the box whose states are all included; otherwise it is
// tested. So
//   pi(q) <= kappa_s h here implies the same with all states (the spread never grows when states are added), and
//   pi(q) > kappa_s h in a cell whose ball is empty is final.
// If the states within reach of the cone enclose a place, but its cell is not in the triangulation of all states, the
// states in the ball of the cell are added until it is. No other place can be safe.
// A state whose cells are all certain needs no further triangulation. The caller triangulates the others: those with
// large cells, and those at the hull.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/coverage/cell_raster.hpp"
#include "geometry/coverage/cover_blocks.hpp"
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
  // Such balls from large to small, up to the first whose centre is certainly in the hull of the states.
  std::vector<EmptyBall> balls;
  std::vector<std::uint32_t> open;  // states of the block with a cell that is not certain
};

// What the blocks share.
struct CoverTask {
  const CoveredStates& states;
  std::span<const CoverBlock> blocks;
  std::span<const std::uint32_t> order;  // of the states (cover_blocks.hpp)
  const Thresholds& limits;
  VoxelLabels& voxels;
};

class BlockCover {
 public:
  explicit BlockCover(const CoverTask& task) : task_(task), seen_(task.states.at.size(), 0) {}
  // Sets the labels safe and sparse of the block's voxels, and mark::unset for the others.
  BlockFindings run(std::size_t block);

 private:
  void gather(const CoverBlock& block);
  void triangulate();
  void label(CellRaster& raster, const CoverBlock& block, BlockFindings& found);
  void keep_balls(std::vector<EmptyBall>& balls, BlockFindings& found);
  void answer(std::vector<std::size_t>& asked);
  void answer_brick(std::span<const std::size_t> asked);
  std::uint8_t mark_at(const Vec3& q);
  bool foreign(const Vec3& centre, double radius, std::uint32_t& state) const;
  bool extend(const Spread& spread);

  CoverTask task_;
  Box known_;                         // all states in it are triangulated [m]
  std::vector<std::uint32_t> local_;  // state of each number of the triangulation
  std::vector<std::uint32_t> seen_;   // by state: the last run that included it
  std::uint32_t runs_ = 0;

  std::unique_ptr<DelaunayIndex> delaunay_;
  PathWalk walk_;
  std::vector<Vec3> around_;  // states near a brick
  Directions directions_;
  ConeSolver solver_;
};

}  // namespace forefeel
