#pragma once
// Workers in other processes, on this machine or others. `mpirun -n 5 forefeel session --mpi …` plans and
// renders in rank 0 and solves in ranks 1 to 4, one job at a time in each. Real clock only. Messages:
//   rank 0 -> r   job (positions, the solution to start from) · cancel · stop
//   r -> rank 0   a result for each state · failure (text) · left, the last message
// Each rank polls for messages while a separate thread solves, so a cancellation takes effect between two
// iterations. Without Boost.MPI, built() returns false and no other function may be called.

#include <memory>

#include "scheduling/workers/generator.hpp"
#include "scheduling/workers/state_solver.hpp"

namespace forefeel {

// This process as a rank of the MPI run; at most one object exists at a time. In rank 0 the destructor tells
// the other ranks to stop.
class MpiGroup {
 public:
  static bool built();
  MpiGroup();  // InputError if MPI works only from the first thread
  ~MpiGroup();
  MpiGroup(const MpiGroup&) = delete;
  MpiGroup& operator=(const MpiGroup&) = delete;

  int rank() const;
  int ranks() const;
  // Ranks above 0: solves the jobs of rank 0; returns when rank 0 sends stop.
  void serve(const std::shared_ptr<const Body>& body, const StateSolverOptions& options);
  // Ranks above 0, instead of serve(): waits at most `seconds` for a stop from rank 0; returns whether it
  // came.
  bool told_to_stop(double seconds);
  [[noreturn]] void abort(int exit_code);
  // Rank 0: the other ranks as workers. The group must outlive them. One thread at a time may use them.
  std::unique_ptr<RealWorkers> workers();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
