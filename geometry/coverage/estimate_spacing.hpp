#pragma once
// The spacing h of states that do not say it: the median distance of a position to its nearest other one,
//   h = median over i of min over j of ||x_i - x_j||,  x_i != x_j
// which is the spacing of a lattice that is mostly full.

#include <span>

#include "geometry/states/state.hpp"

namespace forefeel {

// [m]; `unknown` with fewer than two positions. Of more than 20 000 states every k-th is measured, 20 000 at
// most; all count as neighbours. States at one position count once. O(n log n).
double estimate_spacing(std::span<const State> states);

}  // namespace forefeel
