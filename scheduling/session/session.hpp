#pragma once
// A headless haptic session. The data goes this way:
//   device -> HIP -> predictor -> policy -> planner -> workers -> state -> state space -> model -> switch -> safety -> device
// Workers solve states, the planner decides which and makes models of those that are known, a 1 kHz loop renders the
// newest model. Both clocks run the same Planner and the same RenderLoop; only who calls them when differs.
//   make_plan (session_plan.hpp)         input and options, checked once
//   run_session                          the run, then its judgement (judge/run_analysis.hpp)
//   SessionResult (log/session_result.hpp)
//
//   SessionInput input{.touched = {.body = body, .space = {.spacing = 6e-3, .box = reach}}};
//   SessionOptions options{.clock = {.kind = Clock::virtual_time, .seconds = 5}};
//   const SessionResult result = run_session(input, options);

#include <functional>

#include "scheduling/log/session_result.hpp"
#include "scheduling/session/session_input.hpp"
#include "scheduling/session/session_options.hpp"

namespace forefeel {

// Throws what run_session() would throw for input that cannot be run (unknown names, a bad trace, no workers …);
// solves and writes nothing.
void check_session(const SessionInput& input, const SessionOptions& options);
// Where the device ends by itself (a trace, a replay), its end [s]; infinite otherwise.
double motion_seconds(const SessionInput& input, const SessionOptions& options);

// when_run: called once after the last frame, before labels and errors are entered, which change `frames`, `switches`
// and `notes`; the result moves, so nothing may refer to it later.
// each_position: where the HIP was in each frame, in order, on a thread of its own and beside the run where that can
// be.
SessionResult run_session(const SessionInput& input, const SessionOptions& options,
                          const ShowProgress& progress = {},
                          const std::function<void(const SessionResult&)>& when_run = {},
                          const std::function<void(const Vec3&)>& each_position = {});

}  // namespace forefeel
