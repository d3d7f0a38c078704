#pragma once
// Runs a headless haptic session. The data flow:
//   device -> HIP -> predictor -> policy -> planner -> workers -> state -> state space
//   state space -> model -> switch -> safety -> device                        (the 1 kHz loop)
//   frames and states -> pipeline -> labels, errors -> SessionResult          (beside the run, then after it)
// The planner chooses states, workers solve them, and the loop renders the newest model of the known states.
// Both clocks use the same Planner and the same RenderLoop; only the callers differ.
//
//   SessionInput input{.touched = {.body = body, .space = {.spacing = 6e-3, .box = reach}}};
//   SessionOptions options{.clock = {.kind = Clock::virtual_time, .seconds = 5}};
//   const SessionPlan plan = make_plan(input, options);      // checks everything once
//   const SessionResult result = run_session(plan);          // or run_session(input, options)
//
// Policy, predictor, device, cost model and workers may be given as objects in input.parts. They replace
// those named in the options.
//
// Threads. run_session() returns when the session is over. Virtual clock: device, policy, predictor and cost model are
// called from the caller's thread. Real clock: the device from the loop's thread; policy, predictor, dispatch() and
// collect() of the workers from the planner's; serve() of the workers from the caller's and its OpenMP team.
// hooks.progress is called from the thread that works, hooks.each_position from one of its own. Hooks must not throw.

#include <functional>

#include "scheduling/common/session_result.hpp"
#include "scheduling/session/session_plan.hpp"

namespace forefeel {

// Callbacks of run_session() while a session runs. Each may be empty.
struct SessionHooks {
  ShowProgress progress = {};
  // Called once after the last frame, before labels and errors are added; these change `frames`, `switches`
  // and `notes`. Keep no reference: the result is moved later.
  std::function<void(const SessionResult&)> when_run = {};
  // Called with the HIP position of each frame, in order [m]. Runs on a separate thread, during the run if
  // possible.
  std::function<void(const Vec3&)> each_position = {};
};

// make_plan() refuses invalid sessions. A failure during the run does not throw:
//   full disk        later states, or later inputs, are not saved
//   failed workers   the session continues with the states known so far
//   failed planner   the session ends early; the force goes to zero as at every end (render/render_loop.hpp)
// result.failures has a line for each, and the rest of the result is valid. If the disk of the cache is full, that is
// only a warning.
SessionResult run_session(const SessionPlan& plan, const SessionHooks& hooks = {});
// Makes the plan and runs it.
SessionResult run_session(SessionInput input, SessionOptions options, const SessionHooks& hooks = {});

}  // namespace forefeel
