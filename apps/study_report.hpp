#pragma once
// The report of a study: one self-contained HTML file.

#include <string>

#include "apps/study_plan.hpp"
#include "apps/study_ranking.hpp"

namespace forefeel {

std::string study_page(const StudyPlan& plan, const StudyResult& result,
                       const std::vector<AxisRanking>& ranked, const std::vector<Contrast>& compared);

}  // namespace forefeel
