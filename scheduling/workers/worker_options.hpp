#pragma once
// Who solves states, and under the virtual clock what that costs.

#include <memory>

#include "scheduling/workers/cost_spec.hpp"
#include "scheduling/workers/generator.hpp"

namespace forefeel {

class MpiGroup;

struct WorkerOptions {
  int count = 2;                       // workers that solve; simulated ones under the virtual clock
  int threads = 0;                     // of reference solves, 0: all; never changes a virtual run's result
  WorkersSpec kind = "threads";        // who they are; simulated threads under the virtual clock
  std::shared_ptr<MpiGroup> mpi = {};  // real clock: its other ranks are the workers; null: threads
  // Virtual clock only.
  CostSpec cost = {};  // of a solve: constant:0.01
  double latency = 0;  // of a message to or from a worker [s]
  // Share of a solve's cost that a neighbour solved on its factor takes: 0.4 to 0.6 was measured on bodies of
  // 1.7 and 8 thousand tetrahedra.
  double batch_share = 0.5;
};

// InputError names the key of a value that cannot be used.
void check(const WorkerOptions& options);

}  // namespace forefeel
