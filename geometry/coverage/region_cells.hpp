#pragma once
// Converts the leaves of regions to boxes with shared corners, so that other programs find the connected
// components. Two boxes of one component that share a facet are connected by shared corners, directly or through
// other boxes. Boxes of different components share no corner.
//
// A small leaf in the middle of a large leaf's facet shares no corner with the large leaf. If nothing else
// connects the two, the large leaf is cut into smaller boxes. So there may be a few more boxes than leaves.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/coverage/region_summary.hpp"

namespace forefeel {

struct RegionCells {
  std::vector<Vec3> points;                           // #P [m]
  std::vector<std::array<std::uint32_t, 8>> corners;  // #C, into points: x fastest, then y, then z
  std::vector<std::uint32_t> leaf;                    // #C: the leaf that the box is a part of
};

RegionCells cells_with_shared_corners(std::span<const RegionLeaf> leaves);

}  // namespace forefeel
