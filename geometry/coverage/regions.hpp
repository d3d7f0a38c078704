#pragma once
// Regions: the box of a state space, divided into labelled cubes. The finest are voxels of side h/4 with the label of
// their centre (coverage.hpp); eight cubes of one label are merged into one leaf. If the box is not a multiple of h/4,
// voxels at its faces are cut off (voxels.hpp). Volumes, components and pictures are sums over leaves.
//
//   fill distance   sup over the box of delta(q)                        [m]
//   largest hole    the largest ball that contains no state and whose centre lies in the box and in the hull of
//                   the states: the largest circumscribed ball of a Delaunay cell
//
// Of a fixed set of states: labels of all voxels are computed once, block by block (block_labels.hpp), by all threads;
// the results do not depend on their number. For the label of single places use StateSpace::region_label().
// Memory: 80 bytes a state, 1 byte a voxel (2 on an adaptive lattice), 8 bytes for each run of equal labels along x
// while components are found, and for each thread the triangulation of a block (up to 60 thousand states and those
// around them).

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/coverage/region_summary.hpp"

namespace forefeel {

class DelaunayIndex;

class Regions {
 public:
  // States nearer than the merge distance to an earlier one are ignored. One thread calls progress with the share done.
  Regions(std::vector<Vec3> states, const StateSpaceOptions& options,
          const std::function<void(double)>& progress = {});
  ~Regions();
  Regions(Regions&&) noexcept;
  Regions& operator=(Regions&&) noexcept;

  const StateSpaceOptions& options() const;
  Label label_at(const Vec3& q) const;                   // of the voxel that holds q, a place of the box
  RegionSummary summary(bool with_leaves = true) const;  // without them, `leaves` is empty; O(voxels)
  double fill_distance() const;                   // [m]; at most 1e-3 h too small; infinite without states
  std::optional<EmptyBall> largest_hole() const;  // nullopt if no cell has its circumcentre in box and hull

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Balls that hold no state, with their centres in the box and in the hull of the states and radii above `least` [m]:
// largest first, none with its centre in a larger one, at most 1000.
std::vector<EmptyBall> empty_balls(const DelaunayIndex& delaunay, const Box& box, double least);

// The largest delta in the box, at most `tolerance` too small [m]. By branch and bound: delta, the distance to the
// nearest state [m], is 1-Lipschitz, so over a part of the box with centre c and half-diagonal e it lies between
// delta(c) and delta(c) + e. known: a value that delta is known to reach [m]; parts where delta is below it are
// skipped.
double largest_distance(const std::function<double(const Vec3&)>& delta, const Box& box, double known,
                        double tolerance);

}  // namespace forefeel
