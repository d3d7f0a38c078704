#pragma once
// Regions: the box of a state space as labelled octree leaves. The finest cells are cubes of h/4 that carry the label
// of their centre; eight children of one label are one leaf: a leaf of any size says what its cubes of h/4 say. Where
// the box is no multiple of h/4, the cubes at its faces are cut off (voxel_grid.hpp). Volumes, components and pictures
// are sums over leaves.
//
//   fill distance   sup over the box of delta(q)                        [m]
//   largest hole    the largest ball that holds no state and is held by states all round, its centre in the box and in
//                   their hull: the largest circumscribed ball of a Delaunay cell. None where no cell has its centre there
//
// Nothing is rebuilt: a state that is added is left with the cubes in its reach, and the leaves whose label it may
// change are found and worked out when they are looked at (label_at: one path from the root) or when somebody settles
// all of them.
// One owner; the const members work out what is pending, so they are not for several threads at once.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/common/types.hpp"
#include "geometry/coverage/coverage.hpp"

namespace forefeel {

class DelaunayIndex;
class PointOctree;
struct StateSpaceOptions;

struct RegionLeaf {
  Box box;  // clipped to the box of the states [m]
  Label label = Label::blank;
  std::uint32_t component = 0;  // index into components()
};

// One of the clusters of directions in which a gap meets known states (bridge.hpp), seen from its inner place.
struct BridgeSide {
  Vec3 direction = Vec3::Zero();  // unit, mean over its states
  double half_angle_deg = 0;      // from the direction to its farthest state
  double distance = 0;            // to its nearest state [m]
  std::size_t states = 0;         // within the gap radius
};

// Facet-connected leaves of one label.
struct RegionComponent {
  Label label = Label::blank;
  double volume = 0;  // [m^3]
  std::size_t leaves = 0;
  Box bounds;                 // [m]
  Vec3 inner = Vec3::Zero();  // centre of its largest leaf [m]
  std::vector<std::uint32_t>
      safe_neighbours;            // safe components that share a facet with it; of a gap, which sparse
                                  // always surrounds, those within (kappa_p + 1/2) h of it
  std::vector<BridgeSide> sides;  // of a gap, nearest first; only of the 1000 largest
};

struct LargestHole {
  double radius = 0;  // [m]
  Vec3 centre = Vec3::Zero();
};

struct RegionSummary {
  std::vector<RegionLeaf> leaves;
  std::vector<RegionComponent> components;  // by label, then by falling volume
  std::array<double, 4> volume{};           // per label [m^3]
  std::array<std::size_t, 4> component_count{};
};

class Regions {
 public:
  // The indexes must outlive the regions; StateSpace::regions() makes and keeps one.
  Regions(const PointOctree& points, DelaunayIndex& delaunay, const StateSpaceOptions& options);
  ~Regions();

  // Label of the leaf that contains q; outside the box that of q itself.
  Label label_at(const Vec3& q) const;
  double finest() const;  // side of the smallest leaf [m]
  const Box& box() const;

  // Works out at most `budget` pending leaves; true when nothing is pending. For a planner's idle time.
  bool settle(std::size_t budget = static_cast<std::size_t>(-1),
              const std::function<void(double)>& progress = {}) const;

  std::array<double, 4> volumes() const;  // [m^3], settles first
  RegionSummary summary() const;          // settles first; O(leaves)
  double fill_distance() const;           // [m], at most 1e-3 h below the supremum; infinite without states
  std::optional<LargestHole> largest_hole() const;

  // A state was added; `disturbed` as DelaunayIndex reports it.
  void inserted(const Vec3& at, std::span<const std::uint32_t> disturbed);
  std::size_t pending() const;  // leaves marked since all were settled

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
