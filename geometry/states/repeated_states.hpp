#pragma once
// Several states at one position: the displacement, and the site where there is one. Two solves of one state agree;
// repeated measurements scatter. A state with force f [N] contradicts the first usable state of its position, with
// force f_1, if
//   |f - f_1| > 1e-6 max(|f|, |f_1|)
// Where states contradict each other, the model uses their mean; each usable state has the same weight.
//
// Errors that neighbouring rows share. No number of rows averages them out, and no row left out shows them.
//   rounding   all forces are multiples of a step q_k [N] in component k, and the noise is less than |q| / 2: along a
//              stroke many rows are then rounded alike. The force may be |q| / 2 off. Forces that are linear on a
//              lattice are multiples of a step too, but they have no noise: less than 2 % of a step
//   courses    the rows of one position differ, but their means are smoother than they could be if the rows differed by
//              chance: the noise of the field is less than half of sigma_r / sqrt(k) for k rows with the deviation
//              sigma_r. So it is with loading and unloading, each smooth. A force may be half their difference off

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
// up to 0.4 N"; empty if none does, or if they are named as hysteresis (misleading.hpp).
std::string contradictions_in_words(const std::string& file, const RepeatedStates& found,
                                    std::span<const State> states);

// Replaces the states of each position where they contradict each other by one state: the mean of force,
// stiffness and energy, with status measured, in the place of the first. All other states, failed ones too, stay
// unchanged.
struct AveragedStates {
  std::vector<State> states;
  RepeatedStates found;
};
// Fills in off_mean and mean_noise too.
AveragedStates averaged(std::vector<State> states);

struct SharedError {
  double rounding = 0, courses = 0;  // [N]; 0: none
  double step = 0;                   // |q| [N]
  double sum() const { return rounding + courses; }
};

// rows: as given, before those of one position are averaged. noise: deviation of one component about the field [N].
SharedError shared_error(std::span<const State> rows, const RepeatedStates& repeated, double noise);

}  // namespace forefeel
