#pragma once
// Groups of neighbouring positions, to be left out together: a prediction from the states close beside a
// position says nothing of a place where there are none.
//   natural   Positions come in clusters (a probe pressed to ten depths at each of 70 places): the edges of
//             the minimum spanning tree, sorted by length, jump by a factor of at least 1.5. The groups are
//             the clusters that remain without the longer edges
//   compact   Otherwise: boxes of two to four neighbouring positions, by halving the longest side

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

// Deterministic; ties by order. O(n^2) time, O(n) memory.
PositionGroups position_groups(std::span<const Vec3> positions);

// Boxes of at most `most` positions, more than half of it, by halving the longest side.
PositionGroups compact_groups(std::span<const Vec3> positions, std::size_t most);

// For each group the part, from 0 to parts - 1, in which it is left out. Groups of one part lie far from each
// other, as far as the positions allow.
std::vector<std::uint32_t> spread_over_parts(std::span<const Vec3> positions, const PositionGroups& groups,
                                             std::size_t parts);

}  // namespace forefeel
