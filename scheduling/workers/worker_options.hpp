#pragma once
// The workers of a session, and the cost of their solves under the virtual clock.

#include <memory>

#include "scheduling/common/arguments.hpp"
#include "scheduling/workers/cost_spec.hpp"

namespace forefeel {

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

}  // namespace forefeel
