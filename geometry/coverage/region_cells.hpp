#pragma once
// The leaves of regions as boxes with shared corners, so that other programs see what is connected: two boxes
// of one component that share a facet are connected over corners that they share, directly or through other
// boxes; boxes of different components share no corner.
//
// A small leaf in the middle of a large one's facet shares no corner with it. Where nothing else connects the
// two, the large leaf is cut into smaller boxes; so there may be a few more boxes than leaves.

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
