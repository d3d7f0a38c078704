#pragma once
// The report of a study: one HTML file that needs no other file.

#include <string>

#include "apps/picture/palette.hpp"
#include "apps/study/planned_study.hpp"
#include "scheduling/study/study_ranking.hpp"
#include "scheduling/study/study_run.hpp"

namespace forefeel {

// Notes for readers about the sustained speeds of these cells; empty if no cell searches one.
std::vector<std::string> sustained_notes(const Study& study, const std::vector<StudyCellResult>& cells);

std::string study_page(const PlannedStudy& planned, const StudyResult& result,
                       const std::vector<AxisRanking>& ranked, const std::vector<Contrast>& compared,
                       const std::vector<std::string>& first,  // lines before all notes
                       const Palette& palette = palette_from_text(std::string(usual_palette)));

}  // namespace forefeel
