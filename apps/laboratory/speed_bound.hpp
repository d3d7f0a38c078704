#pragma once
// The highest speed at which a sustained session of a study's cell could hold if its models were exact from the first
// moment on at which anything can be solved (exact_rendering.hpp): what the damped switch alone leaves of the motion.
// A scheduler decides nothing in it; no number of workers changes it. Not a theorem for models that are wrong.

#include "apps/study/study_plan.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

struct SpeedBound {
  double known = 0;          // from when on the force is known, with rest first [s]
  double speed = 0;          // by the search of study_speed.hpp [m/s]; 0 where even its lowest fails
  double settled_after = 0;  // at that speed, from then until the offset is gone [s]
};

// The cell's policy, workers and model count nothing. first_guess: before that the hand feels the guess of
// solver/body/contact_stiffness.hpp, else nothing.
SpeedBound speed_bound(const StudyPlan& plan, const StudyCell& cell, ReferenceService& references,
                       bool first_guess);

}  // namespace forefeel
