#pragma once
// generate_lattice() by all ranks of a run: the same states, bit by bit, on machines with the same instruction set.

#include <functional>
#include <memory>
#include <vector>

#include "scheduling/workers/farm.hpp"
#include "solver/lattice/generate.hpp"

namespace forefeel {

struct RankedGenerateReport {
  GenerateReport states;  // threads: ranks that solved
  FarmReport farm;
};

// Rank 0. sink and progress as for generate_lattice(), called by the calling thread. The pool has begun.
RankedGenerateReport generate_with_ranks(RankPool& pool, std::shared_ptr<const Body> body,
                                         const LatticeOptions& options, const std::vector<State>& known,
                                         const std::function<void(State)>& sink,
                                         const std::function<void(std::size_t, std::size_t)>& progress,
                                         const FarmOptions& farm);

// The other ranks.
std::unique_ptr<RankWorker> make_lattice_worker(std::shared_ptr<const Body> body, LatticeOptions options,
                                                const std::stop_token& ended);

}  // namespace forefeel
