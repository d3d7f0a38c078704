#pragma once
// Workers of a session under the real clock in other processes: worker w is rank w + 1. `mpirun -n 5 forefeel
// session --mpi …` plans and renders in rank 0 and solves in ranks 1 to 4, one job at a time in each. If a rank is
// lost, its states are returned as cancelled, so the planner can give them to others.

#include <memory>

#include "scheduling/workers/generator.hpp"
#include "scheduling/workers/rank_pool.hpp"
#include "scheduling/workers/rank_server.hpp"
#include "scheduling/workers/state_solver.hpp"

namespace forefeel {

// For rank 0. The pool must outlive the workers; one thread at a time may use both.
std::unique_ptr<RealWorkers> make_rank_workers(RankPool& pool);

// For the other ranks.
std::unique_ptr<RankWorker> make_state_worker(std::shared_ptr<const Body> body,
                                              const StateSolverOptions& options);

}  // namespace forefeel
