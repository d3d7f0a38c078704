#pragma once
// An upper bound of the speed that a cell of a study with [sustained] can reach with exact models. The exact force is
// assumed to be known everywhere from the moment at which the first solve can be finished. So only the damped switch
// causes errors (record/exact_rendering.hpp). The bound depends neither on the scheduler nor on the number of workers.
// Inexact models may exceed it.

#include "scheduling/study/study_plan.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

struct SpeedBound {
  double known = 0;          // time from which the force is known, with rest solved first [s]
  double speed = 0;          // by the search of sustained_speed.hpp [m/s]; 0 if even the lowest fails
  double settled_after = 0;  // at that speed, time from `known` until the offset is gone [s]
};

// The cell's policy, workers and model are not used. Until the force is known, the guess of
// solver/equilibrium/first_guess.hpp is rendered if first_guess is set, else zero.
SpeedBound speed_bound(const SustainedOptions& sought, const StudyCell& cell, const SessionInput& input,
                       ReferenceService& references, bool first_guess);

}  // namespace forefeel
