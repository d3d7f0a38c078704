#pragma once
// Groups of neighbouring positions that are held out together. Holding out single positions is not enough: a prediction
// from states close by says nothing about places far from all states.
//   natural   if the positions form clusters (a probe pressed to ten depths at each of 70 places): the sorted lengths
//             of the edges of the minimum spanning tree then jump by a factor of at least 1.5. The groups are the
//             clusters that remain when the longer edges are removed
//   compact   otherwise: boxes of two to four neighbouring positions, made by halving the longest side

#include <cstddef>
#include <cstdint>
#include <optional>
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

// Divides positions into parts that are held out in turn, so that what is held out is as hard to predict as the wanted
// places are: as far from the rest, in distance and direction, as those lie from the positions.
//
// Let x - x_i be the displacement of a place from the nearest position, d the median of its length over the wanted
// places, D that over the held-out positions from the rest. Natural groups (strokes of a raster, presses) are held out
// if d / 2.5 <= D <= 4 d; of several levels, that with the least |log(D / d)|. Rows are sparse in all directions
// between such groups, so directions need no comparison.
//
// Else compact groups of 1, 2, 4, ... positions are tried too. Let w_k be the shares of the eigenvalues in the second
// moment of the wanted displacements, u_k its eigenvectors, and h_k the shares along u_k of the held-out ones:
//   mismatch = |log(D / d)| + max(0, 1/2 sum_k w_k |log(h_k / w_k)| - 0.3)
// The grouping with the least mismatch is taken (after nearest neighbour distance matching, Milà et al., Methods in
// Ecology and Evolution 13, 2022). If the wanted places are unknown, natural groups are, or compact groups of 4.
struct Division {
  PositionGroups groups;
  std::vector<std::uint32_t> part;  // of each group, from 0
  std::size_t count = 0;            // of parts, at most 8; 0: fewer than 3 groups
  double mismatch = 0;              // natural groups that fit: 0
  bool alike = true;                // what is held out is no easier to predict than the wanted places

  bool fits() const;  // mismatch of at most log 2.5
};

// at: positions [m]. wanted: displacements of the places from the nearest position [m]; empty: unknown.
Division best_division(std::span<const Vec3> at, std::span<const Vec3> wanted);

// Natural groups alone; nothing if none fit.
std::optional<Division> natural_division(std::span<const Vec3> at, std::span<const Vec3> wanted);

}  // namespace forefeel
