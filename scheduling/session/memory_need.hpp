#pragma once
// How much memory a session will take, estimated before anything of it is allocated.

#include "scheduling/session/planned_session.hpp"

namespace forefeel {

// Bytes, at most.
struct MemoryNeed {
  double frames = 0;      // records, their evaluation and their tables while they are written
  double workers = 0;     // real clock: a solver and a thread for each; simulated ones take nothing
  double references = 0;  // a solver for each thread of the reference solves
  double all() const { return frames + workers + references; }
};
MemoryNeed memory_need(const SessionPlan& plan);

// Throws InputError if the session needs more than `available` [bytes]: what it would take, what there is,
// and the key that takes the most (session.seconds, session.workers, session.threads). Also refuses more
// worker threads than a process can well have.
void check_memory(const SessionPlan& plan, double available);

}  // namespace forefeel
