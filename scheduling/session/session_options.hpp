#pragma once
// All options of a session: the sum of what its parts take. Each part has its defaults, its meaning and its
// check in a header of its own.

#include <cstdint>

#include "approx/switch/force_switch.hpp"
#include "scheduling/judge/judging_options.hpp"
#include "scheduling/judge/stop_options.hpp"
#include "scheduling/motion/motion_options.hpp"
#include "scheduling/plan/planning_options.hpp"
#include "scheduling/render/safety.hpp"
#include "scheduling/render/session_model_options.hpp"
#include "scheduling/session/clock_options.hpp"
#include "scheduling/workers/worker_options.hpp"

namespace forefeel {

struct SessionOptions {
  ClockOptions clock;
  MotionOptions motion;
  PlanningOptions planning;
  WorkerOptions workers;
  SessionModelOptions model;
  SwitchOptions switching;
  SafetyOptions safety;
  JudgingOptions judging;
  StopOptions stop;
  std::uint64_t seed = 0;  // of device, policy and cost
};

// The check of every part, and of what no part knows alone. InputError names the key: "session.seconds".
void check(const SessionOptions& options);

}  // namespace forefeel
