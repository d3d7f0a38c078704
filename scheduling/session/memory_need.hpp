#pragma once
// Estimates the memory of a session before anything is allocated.

#include <cstddef>
#include <memory>

#include "solver/body/body.hpp"

namespace forefeel {

// The quantities that determine the memory of a session.
struct MemoryRequest {
  std::shared_ptr<const Body> body;
  std::size_t frames = 0;
  double seconds = 0;  // length of the session [s]
  int workers = 0;     // threads that solve under the real clock; simulated workers take nothing
  int threads = 0;     // of reference solves, as given (workers/reference_service.hpp)
  int jet = 1;         // order of the force that states keep
};

// Bytes, at most.
struct MemoryNeed {
  double frames = 0;      // records, their evaluation and their tables while they are written
  double workers = 0;     // real clock: a solver and a thread for each; simulated ones take nothing
  double references = 0;  // a solver for each thread of the reference solves
  double all() const { return frames + workers + references; }
};
MemoryNeed memory_need(const MemoryRequest& asked);

// Throws InputError if the session needs more than `available` [bytes]. The error names the need, the available memory
// and the key with the largest share (session.seconds, session.workers, session.threads). Also throws for more worker
// threads than a process can reasonably run.
void check_memory(const MemoryRequest& asked, double available);

}  // namespace forefeel
