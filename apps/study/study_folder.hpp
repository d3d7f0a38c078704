#pragma once
// Runs a study in a folder. Each finished cell is written at once to its own file, DIR/cells/KEY.json,
// completely or not at all. If the process is killed, only the cells being run are lost; a rerun resumes. KEY is a hash
// of the cell's content (scene, body, options, seed, traces, version). So a cell is found again even if the rest of the
// study changes, and it is never mistaken for another cell.

#include <filesystem>

#include "apps/console/console.hpp"
#include "scheduling/study/study_run.hpp"
#include "scheduling/workers/rank_pool.hpp"

namespace forefeel {

// The first SIGINT or SIGTERM ends the study: finished cells are kept, running cells are dropped. Throws
// InputError if another process writes to the same folder.
// ranks: these run the cells, and only this process writes; null: threads run them.
StudyResult run_study_in(const std::filesystem::path& folder, const StudyPlan& plan, const Globals& globals,
                         RankPool* ranks = nullptr);

}  // namespace forefeel
