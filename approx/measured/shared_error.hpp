#pragma once
// Errors that neighbouring rows share. No number of rows averages them out, and no row left out shows them.
//   rounding   all forces are multiples of a step q_k [N] in component k, and the noise is less than |q| / 2: along a
//              stroke many rows are then rounded alike. The force may be |q| / 2 off. Forces that are linear on a
//              lattice are multiples of a step too, but they have no noise: less than 2 % of a step
//   courses    the rows of one position differ, but their means are smoother than they could be if the rows differed by
//              chance: the noise of the field is less than half of sigma_r / sqrt(k) for k rows with the deviation
//              sigma_r. So it is with loading and unloading, each smooth. A force may be half their difference off

#include <span>

#include "geometry/states/repeated_states.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

struct SharedError {
  double rounding = 0, courses = 0;  // [N]; 0: none
  double step = 0;                   // |q| [N]
  double sum() const { return rounding + courses; }
};

// rows: as given, before those of one position are averaged. noise: deviation of one component about the field [N].
SharedError shared_error(std::span<const State> rows, const RepeatedStates& repeated, double noise);

}  // namespace forefeel
