#pragma once
// Regions as plain data, from the labels of all voxels (voxels.hpp): the largest cubes of one label (leaves), their
// components and volumes, what is beside them, and the sides of the gaps. Leaves are cubes of 2^k voxels. Their order,
// and that of the components, depends on the labels alone.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "geometry/coverage/coverage.hpp"
#include "geometry/coverage/voxels.hpp"

namespace forefeel {

struct RegionLeaf {
  Box box;  // clipped to the box of the states [m]
  Label label = Label::blank;
  std::uint32_t component = 0;  // index into RegionSummary::components
};

// One cluster of the directions in which a gap meets known states, seen from the gap's inner place.
struct BridgeSide {
  Vec3 direction = Vec3::Zero();  // unit, mean over its states
  double half_angle_deg = 0;      // from the direction to its farthest state
  double distance = 0;            // to its nearest state [m]
  std::size_t states = 0;         // within the gap radius
};

// Leaves of one label that are connected over shared facets.
struct RegionComponent {
  Label label = Label::blank;
  double volume = 0;  // [m^3]
  std::size_t leaves = 0;
  Box bounds;                 // [m]
  Vec3 inner = Vec3::Zero();  // centre of its largest leaf [m]
  // Safe components next to it: those that share a facet with it. A gap is always surrounded by sparse; for a
  // gap these are the safe components within (kappa_p + 1/2) h.
  std::vector<std::uint32_t> safe_neighbours;
  std::vector<BridgeSide> sides;  // of a gap, nearest first; only for the 1000 largest gaps
};

// A ball that holds no state.
struct EmptyBall {
  double radius = 0;  // [m]
  Vec3 centre = Vec3::Zero();
};

struct RegionSummary {
  std::vector<RegionLeaf> leaves;
  std::vector<RegionComponent> components;  // by label, then by falling volume
  ByLabel<double> volume{};                 // [m^3]
  ByLabel<std::size_t> component_count{};
  std::size_t leaf_count = 0;  // also known where `leaves` is left out
};

// rim: how far from a gap around a place its safe neighbours may lie [m] (rim_reach()).
using RimReach = std::function<double(const Vec3&)>;
// Without leaves, only their number is found (leaf_count). The sides of gaps are left to find_sides().
RegionSummary summarise(const VoxelLabels& voxels, const RimReach& rim, bool with_leaves);

// Regions by sampling: a label for the centre of every voxel of side h/4. label: called by several threads at once.
// InputError beyond 4e8 voxels.
RegionSummary sample_regions(const Box& box, double spacing, double rim,
                             const std::function<Label(const Vec3&)>& label);

// Largest distance of a gap to its safe neighbours: the thickness kappa_p h of its sparse rim plus h/2 [m].
double rim_reach(double sparse_distance, double spacing);  // kappa_p, h [m]

// The sides of a bridge: clusters of the directions in which known states lie, seen from inside a gap (an unknown
// region between known ones). Two directions belong to one side if a chain of directions joins them in steps of at most
// the link angle. Two states at a distance h, seen from kappa_p h [m] or farther, are at most 2 asin(1 / (2 kappa_p))
// apart (39 degrees for kappa_p = 1.5). With that link angle, states of spacing h always form one side.
double bridge_link_deg(double sparse_distance);  // link angle [deg] for kappa_p
// offsets: states within the gap radius, relative to the place [m]. Nearest side first.
std::vector<BridgeSide> bridge_sides(std::span<const Vec3> offsets, double link_deg);
// Fills RegionComponent::sides of the 1000 largest gaps, seen from their inner places. near: appends the states within
// the gap radius of a place, relative to it [m].
using StatesNear = std::function<void(const Vec3& place, std::vector<Vec3>& offsets)>;
void find_sides(std::vector<RegionComponent>& components, double sparse_distance, const StatesNear& near);

}  // namespace forefeel
