#pragma once
// A study's results as files and documents.

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "scheduling/study/study_ranking.hpp"

namespace forefeel {

// cells.csv: one row a cell, in the order of the study; the same bytes for the same study however many
// threads ran it and however often it was resumed. A column for each varied key, seed, then the columns of
// the cells: all that occur, in order of first appearance, without those that are varied keys already.
// Unknown values are empty.
std::string cells_csv(const Study& study, const std::vector<StudyCellResult>& cells);

// Rankings and contrasts. won, lost and verdict (1 better, -1 worse, 0 not shown) are those of the metric, of
// which less may be better.
nlohmann::ordered_json ranking_json(const Study& study, const std::vector<AxisRanking>& rankings,
                                    const std::vector<Contrast>& contrasts);

}  // namespace forefeel
