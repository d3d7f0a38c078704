#pragma once
// The report of a study: one HTML file that needs no other file.

#include <string>

#include "apps/study/planned_study.hpp"
#include "scheduling/study/study_ranking.hpp"
#include "scheduling/study/study_run.hpp"

namespace forefeel {

// What a reader must know of sustained speeds in these cells; empty where none were sought.
std::vector<std::string> sustained_notes(const Study& study, const std::vector<StudyCellResult>& cells);

std::string study_page(const PlannedStudy& planned, const StudyResult& result,
                       const std::vector<AxisRanking>& ranked, const std::vector<Contrast>& compared);

}  // namespace forefeel
