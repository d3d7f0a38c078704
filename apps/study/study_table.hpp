#pragma once
// A study's results as files and documents.

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "scheduling/study/study_ranking.hpp"
#include "scheduling/study/study_verdict.hpp"

namespace forefeel {

// cells.csv: one row per cell, in the order of the study. The same study gives the same bytes for any number
// of threads and resumptions. Columns: one per varied key; seed; then every result column that occurs in a
// cell and is not a varied key, in order of first appearance. Unknown values are empty.
std::string cells_csv(const Study& study, const std::vector<StudyCellResult>& cells);

// Rankings and contrasts. won, lost and verdict (1 better, -1 worse, 0 not significant) follow the metric's
// direction: for some metrics a smaller value is better.
nlohmann::ordered_json ranking_json(const Study& study, const std::vector<AxisRanking>& rankings,
                                    const std::vector<Contrast>& contrasts);

// The table of devices, as printed: a row of texts for each, below these titles.
std::vector<std::string> device_titles();
std::vector<std::string> device_row(const StudyDevice& device);
nlohmann::ordered_json devices_json(const std::vector<StudyDevice>& devices);

}  // namespace forefeel
