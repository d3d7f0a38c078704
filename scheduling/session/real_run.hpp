#pragma once
// A session under the real clock. Three kinds of threads:
//   loop      of real-time priority, with locked memory where the system permits it
//   planner   receives states, makes models, dispatches
//   workers   solve
// They share LoopLink (render/render_loop.hpp) and the workers' own queue, nothing else.

#include "scheduling/session/session_plan.hpp"

namespace forefeel {

// Enters all but labels, errors and what judging adds. Solves the states of --arrivals and --replay before
// the first frame. Throws what a thread threw, after all have ended.
void run_real(const SessionPlan& plan, ReferenceService& references, SessionResult& result,
              const ShowProgress& show);

}  // namespace forefeel
