#pragma once
// Runs a session under the real clock, with three kinds of threads:
//   loop      with real-time priority and locked memory if the system permits
//   planner   receives states, makes models, dispatches
//   workers   solve
// They share only LoopLink (render/render_loop.hpp) and the workers' own queue.

#include "scheduling/session/session_plan.hpp"

namespace forefeel {

// Fills the result, except for labels, errors and other values of the judge. Solves the states of --arrivals
// and --replay before the first frame. After all threads have ended, rethrows an exception of any of them.
void run_real(const SessionPlan& plan, ReferenceService& references, SessionResult& result,
              const ShowProgress& show);

}  // namespace forefeel
