#pragma once
// Runs a study in a folder. Each cell is a file of its own there, DIR/cells/KEY.json, written whole or not at
// all the moment it is done: a kill loses only the cells under way, and a rerun resumes. KEY is the content
// of the cell (scene, body, options, seed, traces, version), so a cell is found again whatever else of the
// study changes, and never mistaken for another.

#include <filesystem>

#include "apps/console/console.hpp"
#include "scheduling/study/study_run.hpp"

namespace forefeel {

// A first SIGINT or SIGTERM ends it: finished cells are kept, those under way are left out. InputError where
// another process writes to the same folder.
StudyResult run_study_in(const std::filesystem::path& folder, const StudyPlan& plan, const Globals& globals);

}  // namespace forefeel
