#pragma once
// What is fixed before the first frame of a session. make_plan() (session_plan.hpp) makes it.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scheduling/judge/session_judge.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/session/arrivals.hpp"
#include "scheduling/session/planner.hpp"
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
  SessionOptions options;  // clock.seconds has been set according to clock.length
  std::shared_ptr<Device> device;
  std::size_t frames = 0;
  std::vector<Vec3> motion = {};  // by frame [m], for policies that read it; else empty
  PlannedArrivals arrivals = {};
  RenderOptions render = {};  // with the lower force limit of device and options
  ModelRecipe model = {};
  int batch = 1;                               // states of one job
  std::vector<std::string> motion_notes = {};  // on a recorded motion (motion/trace_check.hpp), one line each
  PlannedGuess guess = {};
};

}  // namespace forefeel
