#pragma once
// Which known forces to leave out, so that their errors are those to expect at other places.
//
// A held position is as hard to predict as a wanted place if it is as far from what is known. So positions
// are left out in groups (position_groups.hpp), and of the ways to group them
//   natural groups (clusters, such as the depths of a probe), and compact ones of 1, 2, 4 and 8 positions,
// that one is taken whose median distance from a held position to its nearest known one is nearest to the
// median distance from a wanted place to its nearest known position (nearest neighbour distance matching,
// Milà et al., Methods in Ecology and Evolution 13, 2022). Where it is not known which places are wanted,
// the groups are the natural ones, or compact ones of 4.
//
// An eighth of the groups is left out at once, far from each other. Of more than 1500 states some patches are
// taken, and a part of their inner half is left out.

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

// What is known and what is held back; away: from each held position to the nearest known one [m].
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

// Quantiles of the errors that are to be expected at wanted places: for each place those of the 25 held
// positions whose distance is nearest to its own (in rank). errors and away: of the held positions. Without
// wanted places the quantiles of all errors.
std::vector<double> expected_quantiles(std::span<const double> errors, std::span<const double> away,
                                       std::span<const double> wanted, std::span<const double> shares);

}  // namespace forefeel
