#pragma once
// Who solves states, and under the virtual clock what that costs.

#include <memory>
#include <string>

namespace forefeel {

class MpiGroup;

struct WorkerOptions {
  int count = 2;                       // workers that solve; simulated ones under the virtual clock
  int threads = 0;                     // of reference solves, 0: all; never changes a virtual run's result
  std::shared_ptr<MpiGroup> mpi = {};  // real clock: its other ranks are the workers; null: threads
  // Virtual clock only.
  std::string cost = "constant:0.01";  // of a solve: constant:S, lognormal:MEDIAN,SIGMA, recorded, paper
  double latency = 0;                  // of a message to or from a worker [s]
  // Share of a solve's cost that a neighbour solved on its factor takes: 0.4 to 0.6 was measured on bodies of
  // 1.7 and 8 thousand tetrahedra.
  double batch_share = 0.5;
};

// InputError names the key of a value that cannot be used.
void check(const WorkerOptions& options);

}  // namespace forefeel
