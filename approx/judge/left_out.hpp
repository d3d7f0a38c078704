#pragma once
// Chooses which known forces to leave out, so that their errors are those to expect at other places.
//
// A held position is as hard to predict as a wanted place if it is as far from the known states. So positions are
// left out in groups (position_groups.hpp). The groupings tried are
//   natural groups (clusters, such as the depths of a probe), and compact groups of 1, 2, 4 and 8 positions
// For each grouping, the median distance from a held position to its nearest known position is compared with the
// median distance from a wanted place to its nearest known position; the grouping with the closest match is used
// (nearest neighbour distance matching, Milà et al., Methods in Ecology and Evolution 13, 2022). If the wanted
// places are unknown, natural groups are used, or else compact groups of 4.
//
// An eighth of the groups, far from each other, is left out at a time. With more than 1500 states, only some patches
// of the states are used, and a part of the inner half of each patch is left out.

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

// The known and the held-back states; away: distance from each held position to the nearest known one [m].
struct Trial {
  std::unique_ptr<StateSpace> known;
  std::vector<State> held;
  std::vector<double> away;
};

struct Trials {
  std::vector<Trial> each;
  std::size_t positions = 0, groups = 0;  // held back, over all trials
};

// states: usable ones, one at each position. wanted: distance from each wanted place to its nearest state
// [m]; empty: not known. No trial with fewer than 3 groups.
Trials leave_out(std::span<const State> states, std::span<const double> wanted, double spacing);

// Quantiles of the errors to expect at the wanted places. Each place contributes the errors of the 25 held positions
// whose distance to known states is nearest to its own (in rank). errors, away: of the held positions. Without
// wanted places, the quantiles of all errors.
std::vector<double> expected_quantiles(std::span<const double> errors, std::span<const double> away,
                                       std::span<const double> wanted, std::span<const double> shares);

}  // namespace forefeel
