#pragma once
// A headless haptic session. The data goes this way:
//   device -> HIP -> predictor -> policy -> planner -> workers -> state -> state space
//   state space -> model -> switch -> safety -> device                        (the 1 kHz loop)
//   frames and states -> pipeline -> labels, errors -> SessionResult          (beside the run, then after it)
// Workers solve states, the planner decides which, and the loop renders the newest model of those that are
// known. Both clocks use the same Planner and the same RenderLoop; only who calls them when differs.
//
//   SessionInput input{.touched = {.body = body, .space = {.spacing = 6e-3, .box = reach}}};
//   SessionOptions options{.clock = {.kind = Clock::virtual_time, .seconds = 5}};
//   const SessionPlan plan = make_plan(input, options);      // checked once; says how long the motion is
//   const SessionResult result = run_session(plan);          // or run_session(input, options)
//
// Policy, predictor, device, cost model and workers may be given as objects in input.parts; they take the
// place of those that the options name.

#include "scheduling/session/session_hooks.hpp"
#include "scheduling/session/session_plan.hpp"

namespace forefeel {

// A session that cannot be run was refused by make_plan(). A failure on the way (a full disk, a worker that
// fails) is thrown after the threads have ended; states that were solved until then are in their file.
SessionResult run_session(const SessionPlan& plan, const SessionHooks& hooks = {});
// The same from what a plan is made of.
SessionResult run_session(SessionInput input, SessionOptions options, const SessionHooks& hooks = {});

}  // namespace forefeel
