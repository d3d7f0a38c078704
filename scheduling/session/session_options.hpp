#pragma once
// All options of a session, grouped by part. Each group has a header with its meaning, defaults and check.

#include <cstdint>

#include "approx/switch/force_switch.hpp"
#include "scheduling/judge/judging_options.hpp"
#include "scheduling/judge/stop_options.hpp"
#include "scheduling/motion/motion_options.hpp"
#include "scheduling/render/safety.hpp"
#include "scheduling/render/session_model_options.hpp"
#include "scheduling/session/clock_options.hpp"
#include "scheduling/session/planning_options.hpp"
#include "scheduling/workers/worker_options.hpp"

namespace forefeel {

struct SessionOptions {
  ClockOptions clock = {};
  MotionOptions motion = {};
  PlanningOptions planning = {};
  WorkerOptions workers = {};
  SessionModelOptions model = {};
  SwitchOptions switching = {};
  SafetyOptions safety = {};
  JudgingOptions judging = {};
  StopOptions stop = {};
  bool record = true;      // record the run's inputs, if the run has a folder (SessionFiles::inputs)
  std::uint64_t seed = 0;  // of all random parts: device, policy, cost
};

// Checks every group, and conditions across groups. Throws InputError with the key, as "session.seconds".
void check(const SessionOptions& options);

}  // namespace forefeel
