#pragma once
// Several states at one position: the displacement, and the site where there is one. Two solves of one state agree;
// repeated measurements scatter. A state with force f [N] contradicts the first usable state of its position, with
// force f_1, if
//   |f - f_1| > 1e-6 max(|f|, |f_1|)
// Where states contradict each other, the model uses their mean; each usable state has the same weight.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

// True if both are usable and their forces differ as above: by more than two tight solves of the same state differ.
bool contradict(const State& a, const State& b);

struct RepeatedStates {
  std::size_t repeated = 0;       // at the position of an earlier state
  std::size_t contradicting = 0;  // usable states that contradict the first usable state at their position
  std::size_t averaged = 0;       // positions that hold such states
  double largest_difference = 0;  // between two forces at one of these positions [N]
  double off_mean = 0;            // 95 % of these forces are no farther from their mean [N]
  double mean_noise = 0;          // deviation of one component of a mean, if the forces differ by chance [N]
};
RepeatedStates repeated_states(std::span<const State> states);

// "F.csv: 3 states contradict another at the same position: averaged at 2 positions, forces there differ by
// up to 0.4 N"; empty if none does.
std::string contradictions_in_words(const std::string& file, const RepeatedStates& found);

// Replaces the states of each position where they contradict each other by one state: the mean of force,
// stiffness and energy, with status measured, in the place of the first. All other states, failed ones too, stay
// unchanged.
struct AveragedStates {
  std::vector<State> states;
  RepeatedStates found;
};
// Fills in off_mean and mean_noise too.
AveragedStates averaged(std::vector<State> states);

}  // namespace forefeel
