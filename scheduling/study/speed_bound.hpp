#pragma once
// The highest speed at which a cell of a sustained study could hold if its models were exact from the first
// moment on at which anything can be solved (record/exact_rendering.hpp): what the damped switch alone leaves
// of the motion. It depends neither on the scheduler nor on the number of workers. It is no bound for models
// that are wrong.

#include "scheduling/study/study_plan.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

struct SpeedBound {
  double known = 0;          // from when on the force is known, with rest solved first [s]
  double speed = 0;          // by the search of sustained_speed.hpp [m/s]; 0 where even its lowest fails
  double settled_after = 0;  // at that speed, from then until the offset is gone [s]
};

// The cell's policy, workers and model play no part. Before the force is known the hand feels the guess of
// solver/body/contact_stiffness.hpp (first_guess), else nothing.
SpeedBound speed_bound(const SustainedOptions& sought, const StudyCell& cell, const SessionInput& input,
                       ReferenceService& references, bool first_guess);

}  // namespace forefeel
