#pragma once
// Everything that is fixed before the first frame of a session. It is checked and made once.
//
// All functions work in the caller's thread and may be called from several threads at once for different plans. A plan
// is an immutable value. Its copies share the device, the other parts given as objects, and the references. Plans that
// share parts must not run at the same time, because parts have state. Registered parts other than the device are made
// anew for each run: run_session() calls their factories again.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "scheduling/render/render_options.hpp"
#include "scheduling/session/arrivals.hpp"
#include "scheduling/session/session_input.hpp"
#include "scheduling/session/session_options.hpp"

namespace forefeel {

struct PlannedArrivals {
  std::vector<Arrival> list;  // by increasing time
  bool given = false;         // states become known at these times, and nothing is dispatched
  bool of_replay = false;     // the replayed run had given arrivals
};

// The first guess of the stiffness (SessionModelOptions::first_guess).
struct PlannedGuess {
  // FirstGuess::softness (equilibrium/first_guess.hpp); unknown: no guess was wanted or made.
  double softness = unknown;
  std::string left_out;  // why there is no first guess; empty: it is rendered, or none was wanted
};

// make_plan() makes it. Constant afterwards; only options.stop may be set later. Copies share one device, so do not run
// two copies at once. The device restarts its motion when asked for an earlier time.
struct SessionPlan {
  SessionInput input;
  SessionOptions
      options;  // clock.seconds has been set according to clock.length, planning.batch by the clock
  std::shared_ptr<Device> device;
  std::size_t frames = 0;
  std::vector<Vec3> motion = {};  // by frame [m], for policies that read it; else empty
  PlannedArrivals arrivals = {};
  RenderOptions render = {};  // with the lower force limit of device and options
  ModelRecipe model = {};
  std::vector<std::string> motion_notes = {};  // on a recorded motion (motion/trace_check.hpp), one line each
  PlannedGuess guess = {};
};

// Makes the plan and reads the files of motion and arrivals, once. Throws InputError for anything that cannot
// run: unknown names, a bad trace, no workers, a factory that throws … Apart from that it throws only std::bad_alloc
// and what parts given as objects throw. Solves and writes nothing.
SessionPlan make_plan(SessionInput input, SessionOptions options);

// The same session, with these states known at the start in addition to those of the plan.
SessionPlan with_known(SessionPlan plan, std::vector<State> known);
// The same session, rendering only these states of another body (SessionInput::foreign). InputError if states arrive at
// given times: they would be solved for the touched body.
SessionPlan with_foreign(SessionPlan plan, std::vector<State> known);
// The same session, appending its solved states to this file.
SessionPlan with_state_file(SessionPlan plan, std::filesystem::path file);

// The same session, recording its inputs in this file (render/input_log.hpp), unless options.record is false.
// program: name and version of the recording program.
SessionPlan with_inputs_file(SessionPlan plan, std::filesystem::path file, std::string program);

// The same session under another policy.
SessionPlan with_policy(SessionPlan plan, const PolicySpec& policy);

}  // namespace forefeel
