#pragma once
// A study's file with its cells, worked out and checked before anything runs or is written.

#include <string>
#include <vector>

#include "apps/scene_input/scene_session.hpp"
#include "apps/study/study_file.hpp"
#include "scheduling/study/study_plan.hpp"

namespace forefeel {

struct PlannedStudy {
  StudyFile file;
  std::vector<Scene> scenes;  // one for each combination; bodies are shared where they are the same
  StudyPlan plan;             // cells in the order of cells.csv, each with a key
  std::vector<std::string> warnings;
};

// InputError names the place in the study for whatever a cell could not run with.
PlannedStudy plan_study(StudyFile file);

// What a cell's result is kept under: the SHA-256 of everything that it depends on. content: what tells the
// session's body and options apart, as a scene's hash does.
std::string cell_key(const std::string& content, const StudyCell& cell, const SessionInput& input,
                     const std::optional<SustainedOptions>& sustained);

}  // namespace forefeel
