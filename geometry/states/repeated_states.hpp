#pragma once
// Several states at one position. Measurements repeat positions and scatter; two solves of one state agree.
//   contradict   |f - f_1| > 1e-6 max(|f|, |f_1|), f_1 the first usable state of the position
// Where states contradict each other the model uses their mean, each usable state with the same weight.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

// Both usable, and the forces differ by more than two tight solves of one state would.
bool contradict(const State& a, const State& b);

struct RepeatedStates {
  std::size_t repeated = 0;       // at the position of an earlier state
  std::size_t contradicting = 0;  // usable states that contradict the first usable state at their position
  std::size_t averaged = 0;       // positions that hold such states
  double largest_difference = 0;  // between two forces at one of these positions [N]
};
RepeatedStates repeated_states(std::span<const State> states);

// "F.csv: 3 states contradict another at the same position: averaged at 2 positions, forces there differ by
// up to 0.4 N"; empty where none does.
std::string contradictions_in_words(const std::string& file, const RepeatedStates& found);

// The states with one at each position where they contradict each other: the mean of force, stiffness and
// energy, measured. It takes the place of the first; all other states, failed ones too, stay as they are.
struct AveragedStates {
  std::vector<State> states;
  RepeatedStates found;
};
AveragedStates averaged(std::vector<State> states);

}  // namespace forefeel
