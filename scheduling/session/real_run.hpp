#pragma once
// Runs a session under the real clock, with three kinds of threads:
//   loop      with real-time priority and locked memory if the system permits
//   planner   receives states, makes models, dispatches
//   workers   solve
// and, where shapes are wanted, one that makes them (shape/shape_thread.hpp).
// They share only LoopLink (render/render_loop.hpp) and the workers' own queue.

#include "scheduling/session/session_plan.hpp"

namespace forefeel {

class ShapeLog;

// Fills the result, except for labels, errors and other values of the judge. Solves the states of --arrivals
// and --replay before the first frame. If the planner or a worker fails, the loop takes the force to zero and
// ends. result.failures then names the reason, and the result holds everything up to then.
//
// The loop wakes at the absolute times of its frames on CLOCK_MONOTONIC; frames that it misses are skipped
// and counted (render/frame_pacer.hpp). The planner's beat and the watchdog use the same clock. Stops of the
// whole process (SIGSTOP, a debugger) thus show as a pause of the loop and of the planner.
void run_real(const SessionPlan& plan, ReferenceService& references, SessionResult& result,
              const ShowProgress& show, ShapeLog* shapes = nullptr);

}  // namespace forefeel
