#pragma once
// Regions: the box of a state space as labelled octree leaves. The finest cells are voxels of side h/4 with
// the label of their centre; eight children of one label are one leaf. Voxels at the faces of a box that is
// no multiple of h/4 are cut off (voxel_grid.hpp). Volumes, components and pictures are sums over leaves.
//
//   fill distance   sup over the box of delta(q)                        [m]
//   largest hole    the largest ball without a state inside and with states all round, its centre in the box
//                   and in the hull of the states: the largest circumscribed ball of a Delaunay cell
//
// Regions are kept up to date, not rebuilt. A new state is stored with the cells in its reach; the leaves
// whose label it may change are resolved when they are looked at: by label_at() on one path from the root, by
// settle() all of them. One owner: const members resolve what is pending, so they must not run in several
// threads at once.

#include <array>
#include <cstddef>
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
  double finest() const;  // side of the smallest leaf [m]
  const Box& box() const;

  // Resolves at most `budget` pending leaves; true when none is left. For the idle time of a planner.
  bool settle(std::size_t budget = static_cast<std::size_t>(-1),
              const std::function<void(double)>& progress = {}) const;

  std::array<double, 4> volumes() const;            // [m^3], settles first
  RegionSummary summary() const;                    // settles first; O(leaves)
  double fill_distance() const;                     // [m]; at most 1e-3 h too small; infinite without states
  std::optional<LargestHole> largest_hole() const;  // nothing if no cell has its centre there

  // To be called after each insertion into the indexes; disturbed: of DelaunayIndex.
  void inserted(const Vec3& at, std::span<const std::uint32_t> disturbed);
  std::size_t pending() const;  // leaves marked since all were settled

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
