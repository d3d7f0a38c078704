#pragma once
// Regions as plain data: labelled leaves, their components, and the gaps' sides. Made by Regions::summary(),
// sample_regions() and CoverageMap.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/coverage/coverage.hpp"

namespace forefeel {

struct RegionLeaf {
  Box box;  // clipped to the box of the states [m]
  Label label = Label::blank;
  std::uint32_t component = 0;  // index into RegionSummary::components
};

// One cluster of the directions in which a gap meets known states (bridge.hpp), seen from the gap's inner
// place.
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

}  // namespace forefeel
