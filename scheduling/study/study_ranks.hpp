#pragma once
// Runs the cells of a study on all ranks of an MPI run; each free rank gets the next cell. The results are the same as
// those of run_study() with threads.

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "scheduling/study/study_run.hpp"
#include "scheduling/workers/farm.hpp"

namespace forefeel {

struct StudyRankOptions {
  const std::atomic<bool>* hurried = nullptr;  // as in StudyRunOptions
  std::function<void(const std::string&)> warn = {};
  FarmOptions farm = {};
};

// For rank 0 and StudyRunOptions::elsewhere. The pool has begun.
FarmReport run_cells_with_ranks(RankPool& pool, const StudyPlan& plan, const std::vector<std::size_t>& cells,
                                const StudyRunOptions::Take& take, const StudyRankOptions& options);

// For the other ranks. They write nothing.
std::unique_ptr<RankWorker> make_cell_worker(std::shared_ptr<const StudyPlan> plan, const RankContext& rank);

}  // namespace forefeel
