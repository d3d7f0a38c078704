#pragma once
// A study with all its cells, checked before anything runs or is written.

#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/scene/scene_session.hpp"
#include "apps/study/study_file.hpp"
#include "scheduling/study/study_plan.hpp"

namespace forefeel {

struct PlannedStudy {
  StudyFile file;
  std::vector<Scene> scenes;  // one per combination; equal bodies are shared
  StudyPlan plan;             // cells in the order of cells.csv, each with a key
  std::vector<std::string> warnings;
};

// Throws InputError if a cell could not run; the error names the place in the study.
// globals: of the field of a body that may be touched anywhere.
PlannedStudy plan_study(StudyFile file, const Globals& globals = Globals());

}  // namespace forefeel
