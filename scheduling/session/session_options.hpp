#pragma once
// All options of a session, grouped by part. Each group has a header with its meaning, defaults and check.

#include <cstdint>
#include <memory>

#include "approx/switch/switch_options.hpp"
#include "scheduling/common/arguments.hpp"
#include "scheduling/judge/judging_options.hpp"
#include "scheduling/motion/motion_options.hpp"
#include "scheduling/render/render_options.hpp"
#include "scheduling/render/session_model_options.hpp"
#include "scheduling/session/planning_options.hpp"
#include "scheduling/workers/cost_spec.hpp"

namespace forefeel {

// The clock of a session and its duration.
enum class Clock {
  real,         // the loop runs in real time; threads or processes solve
  virtual_time  // simulates loop and workers; same bytes on every machine
};

// When a session ends. Paths and hands never end by themselves; they run for `seconds`.
enum class RunLength {
  seconds,  // after `seconds`; the last position of a shorter motion is held
  motion,   // with the motion
  shorter   // with the motion, but after `seconds` at the latest
};

struct ClockOptions {
  Clock kind = Clock::real;
  double seconds = 20;  // [s]
  RunLength length = RunLength::seconds;
  double frame = 1e-3;  // time from frame to frame [s]
};

// Throws InputError with the key of an invalid value.
void check(const ClockOptions& options);

class RankPool;

// The workers of a session: a name and the settings behind it (generator.hpp). Built in: "threads".
using WorkersSpec = Registered;

struct WorkerOptions {
  int count = 2;                         // workers that solve; simulated ones under the virtual clock
  int threads = 0;                       // of reference solves, 0: all; does not affect virtual results
  WorkersSpec kind = "threads";          // their kind; "threads" is simulated under the virtual clock
  std::shared_ptr<RankPool> ranks = {};  // real clock: these ranks are the workers; null: threads
  // Virtual clock only.
  CostSpec cost = {};  // of a solve: constant:0.01
  double latency = 0;  // of a message to or from a worker [s]
  // Cost of a neighbour solved with a state's factorisation, divided by the cost of that state. Measured: 0.4 to
  // 0.6 on bodies of 1.7 and 8 thousand tetrahedra.
  double batch_share = 0.5;
};

// Throws InputError with the key of an invalid value.
void check(const WorkerOptions& options);

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
