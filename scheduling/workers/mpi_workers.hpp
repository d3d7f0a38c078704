#pragma once
// Workers in other processes, on this machine or others: `mpirun -n 5 forefeel session --mpi …` plans and renders in rank 0
// and solves in ranks 1 to 4, one state (or one batch of neighbours) at a time in each. Real clock only.
//   rank 0 -> r   job (positions, the solution to start from) · cancel · stop
//   r -> rank 0   a result for each state · failure (text) · left, the last message
// A rank polls for messages while a thread of its own solves, so that a cancellation is seen between iterations. Builds
// without Boost.MPI have none of it: built() is false.

#include <memory>

#include "scheduling/workers/generator.hpp"
#include "scheduling/workers/state_solver.hpp"

namespace forefeel {

// The process's membership; one at a time. In rank 0 its end tells the other ranks to stop.
class MpiGroup {
 public:
  static bool built();
  MpiGroup();  // InputError where MPI cannot be used from a thread other than the first
  ~MpiGroup();
  MpiGroup(const MpiGroup&) = delete;
  MpiGroup& operator=(const MpiGroup&) = delete;

  int rank() const;
  int ranks() const;
  // Ranks above 0: solves what rank 0 sends until it says stop.
  void serve(const std::shared_ptr<const Body>& body, const StateSolverOptions& options);
  // Ranks above 0, instead of serve(): whether rank 0 says stop within that time [s].
  bool told_to_stop(double seconds);
  [[noreturn]] void abort(int exit_code);
  // Rank 0. now: session time [s]. Its calls of MPI come from whichever one thread uses it.
  std::unique_ptr<RealWorkers> workers(std::function<double()> now);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
