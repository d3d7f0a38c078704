#pragma once
// What of given states misleads whoever uses them, in words: a stiffness that does not fit the forces
// (stiffness_agreement.hpp), another unit, forces that pull (force_trend.hpp), a force that is alone, loading and
// unloading (hysteresis.hpp).
//
// far     one row is so far from all others that these span less than a fifth of what they span with it, and less than
//         3 m: a tracker that was lost
// time    x rises from row to row by equal steps from 0 or more, while y or z goes back and forth
// unit    neighbouring states are over 20 h apart, or all of them span over 3 m, more than a hand reaches
// alone   a force F_i that is farther than 8 R from those of its 12 nearest other places, of which no two differ by
//         more than R > 0. Rows about one place count once. A step or a kink is not alone: its neighbours lie on both
//         sides. Said of at most 1 % of the states.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

// The row that is far from all others, from 0.
std::optional<std::size_t> far_row(std::span<const State> states);

// One line each; none: nothing was found. spacing: h [m], or unknown. O(n^2) of up to 20,000 states; of more, lone
// forces are not sought.
std::vector<std::string> misleading(std::span<const State> states, double spacing);

}  // namespace forefeel
