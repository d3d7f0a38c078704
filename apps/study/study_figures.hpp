#pragma once
// The figures of a study's report, as gnuplot scripts (plot.hpp).

#include <optional>
#include <string>
#include <vector>

#include "apps/picture/palette.hpp"
#include "apps/session/report_figures.hpp"
#include "scheduling/common/session_result.hpp"
#include "scheduling/study/study_ranking.hpp"

namespace forefeel {

// As shown: "clairvoyant (bound)".
std::string name_of(const StudyAxis& axis, std::size_t level);
// A value of a metric in the unit of its title.
double in_unit(const StudyMetric& metric, double value);
// False for an interval without information: unknown, without width, or nearly as wide as the metric's whole range.
bool says_something(const StudyMetric& metric, const ConfidenceInterval& interval);

// The ranking of one axis of the study. The plotted range fits the means and the bootstrap intervals. nullopt if there
// is no value.
std::optional<Figure> ranking_figure(const Study& study, const AxisRanking& entry, const Palette& palette);
// Mean ranks over the motions with the critical difference (Demsar, JMLR 7, 2006). nullopt below four motions.
std::optional<Figure> ranks_figure(const Study& study, const AxisRanking& entry, const Palette& palette);
// One curve for each value of the first axis, over an axis of numbers. nullopt if that axis has fewer than two numbers.
std::optional<Figure> curves_figure(const Study& study, const std::vector<StudyCellResult>& cells,
                                    std::size_t axis, const Palette& palette);
// All of a report: rankings, then curves.
std::vector<Figure> study_figures(const Study& study, const std::vector<StudyCellResult>& cells,
                                  const std::vector<AxisRanking>& ranked, const Palette& palette);

// Gantt chart of the solves: one row per worker, one bar per solve. The colour is the label of the region
// that the state was planned for.

// Bars of cancelled solves are thin; bars of states that no model used have half the height. The lowest row
// shows the label at the HIP.
Figure gantt_figure(const SessionResult& result, double seconds, int workers);

}  // namespace forefeel
