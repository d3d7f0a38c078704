#pragma once
// Runs a session under the real clock, with three kinds of threads:
//   loop      with real-time priority and locked memory if the system permits
//   planner   receives states, makes models, dispatches
//   workers   solve
// and, where shapes are wanted, one that makes them (shape/shape_thread.hpp).
// They share only LoopLink (render/loop_link.hpp) and the queue of the workers.

#include "scheduling/session/session_setup.hpp"

namespace forefeel {

class InputLog;
class ShapeLog;

// What is written during the run; null: nothing.
struct RunLogs {
  ShapeLog* shapes = nullptr;
  InputLog* inputs = nullptr;  // what comes in (render/input_log.hpp)
};

// Fills the result, except for labels, errors and other values of the judge. Solves the states of --arrivals
// and --replay before the first frame. If the planner fails, the loop takes the force to zero and ends;
// result.failures says why, and the result holds what was done until then. If a worker fails, the others continue. If
// all have failed, the loop continues with the known states, and result.failures says so.
//
// The loop wakes at the absolute times of its frames on CLOCK_MONOTONIC; frames that it misses are skipped and counted
// (render/loop_thread.hpp). The planner's heartbeat and the watchdog use the same clock, so a stop of the whole process
// (SIGSTOP, a debugger) shows as a pause of both loop and planner.
void run_real(const RunSetup& setup, ReferenceService& references, SessionResult& result,
              const ShowProgress& show, const RunLogs& logs = {});

}  // namespace forefeel
