#pragma once
// Groups of neighbouring positions that are held out together. Holding out single positions is not enough: a prediction
// from states close by says nothing about places far from all states.
//   natural   if the positions form clusters (a probe pressed to ten depths at each of 70 places): the sorted lengths
//             of the edges of the minimum spanning tree then jump by a factor of at least 1.5. The groups are the
//             clusters that remain when the longer edges are removed
//   compact   otherwise: boxes of two to four neighbouring positions, made by halving the longest side

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

struct PositionGroups {
  std::vector<std::uint32_t> of;  // group of each position, from 0
  std::size_t count = 0;
  bool natural = false;
};

// The natural groups, those with the largest jump first; up to three levels, as rows held at a depth and presses. Empty
// if there are none. Deterministic; ties by order. O(n^2) time, O(n) memory.
std::vector<PositionGroups> natural_groups(std::span<const Vec3> positions);

// The first of these, or else compact groups of at most 4.
PositionGroups position_groups(std::span<const Vec3> positions);

// Boxes of at most `most` positions, more than half of it, by halving the longest side. at_gaps: instead split at a gap
// of over a quarter of that side, if there is one near the middle, so that no box holds rows of two lines or levels.
PositionGroups compact_groups(std::span<const Vec3> positions, std::size_t most, bool at_gaps = false);

// Assigns each group to the part, 0 to parts - 1, in which it is held out. Groups of one part lie as far from each
// other as the positions allow.
std::vector<std::uint32_t> spread_over_parts(std::span<const Vec3> positions, const PositionGroups& groups,
                                             std::size_t parts);

}  // namespace forefeel
