#pragma once
// Regions: the box of a state space, divided into labelled octree leaves. The finest cells are voxels of side
// h/4 with the label of their centre; eight children of one label are merged into one leaf. If the box is not a
// multiple of h/4, voxels at its faces are cut off (voxel_grid.hpp). Volumes, components and pictures are sums
// over leaves.
//
//   fill distance   sup over the box of delta(q)                        [m]
//   largest hole    the largest ball that contains no state and whose centre lies in the box and in the hull of
//                   the states: the largest circumscribed ball of a Delaunay cell
//
// Regions are updated, not rebuilt. A new state is stored with the cells in its reach. The leaves whose label it
// may change are resolved later: label_at() resolves those on one path from the root, settle() all of them.
// Const members resolve pending leaves, so only one thread may use the regions at a time.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/coverage/region_summary.hpp"

namespace forefeel {

class DelaunayIndex;
class PointOctree;
struct StateSpaceOptions;

class Regions {
 public:
  // The indexes must outlive the regions; StateSpace::regions() makes and keeps one.
  Regions(const PointOctree& points, DelaunayIndex& delaunay, const StateSpaceOptions& options);
  ~Regions();

  // Label of the leaf that contains q; outside the box, the label at q itself.
  Label label_at(const Vec3& q) const;

  void settle(const std::function<void(double)>& progress = {}) const;  // resolves all leaves
  RegionSummary summary() const;                                        // settles first; O(voxels)
  double fill_distance() const;                   // [m]; at most 1e-3 h too small; infinite without states
  std::optional<EmptyBall> largest_hole() const;  // nullopt if no cell has its circumcentre in box and hull

  // To be called after each insertion into the indexes; disturbed: of DelaunayIndex.
  void inserted(const Vec3& at, std::span<const std::uint32_t> disturbed);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
