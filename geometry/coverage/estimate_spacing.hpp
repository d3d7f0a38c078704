#pragma once
// Estimates the spacing h of states that come without one: the median distance of a position to the nearest
// other position,
//   h = median over i of min over j of ||x_i - x_j||,  x_i != x_j
// For a lattice that is mostly full, this is the lattice spacing.

#include <span>

#include "geometry/states/state.hpp"

namespace forefeel {

// Returns h [m], or `unknown` with fewer than two positions. With more than 20 000 states only every k-th is
// measured, at most 20 000 of them; all states count as neighbours. States at one position count once. O(n log n).
double estimate_spacing(std::span<const State> states);

}  // namespace forefeel
