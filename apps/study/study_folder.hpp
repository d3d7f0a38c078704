#pragma once
// Runs a study in a folder. Each finished cell is written at once to its own file, DIR/cells/KEY.json,
// completely or not at all. If the process is killed, only the cells being run are lost; a rerun resumes. KEY is a hash
// of the cell's content (scene, body, options, seed, traces, version). So a cell is found again even if the rest of the
// study changes, and it is never mistaken for another cell.

#include <filesystem>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "scheduling/study/study_run.hpp"

namespace forefeel {

struct StudyPlaces {
  std::filesystem::path folder;
  std::vector<std::string> parts = {};  // folders of the same study, whose cells are copied into `folder`
  std::string manifest = {};            // written as study.json once no other process can write here
};

// InputError for a folder that holds no cell of this study.
void check_parts(const std::vector<std::string>& parts, const StudyPlan& plan);

// The first SIGINT or SIGTERM ends the study: finished cells are kept, running cells are dropped. Throws
// InputError if another process writes to the same folder.
StudyResult run_study_in(const StudyPlaces& places, const StudyPart& part, const StudyPlan& plan,
                         const Globals& globals);

}  // namespace forefeel
