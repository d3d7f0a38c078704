#pragma once
// The report of a study: one self-contained HTML file.

#include <string>

#include "apps/study/study_plan.hpp"
#include "apps/study/study_ranking.hpp"

namespace forefeel {

// What a reader must know of sustained speeds in these cells; empty where none were sought.
std::vector<std::string> sustained_notes(const Study& study, const std::vector<CellColumns>& cells);

std::string study_page(const StudyPlan& plan, const StudyResult& result,
                       const std::vector<AxisRanking>& ranked, const std::vector<Contrast>& compared);

}  // namespace forefeel
