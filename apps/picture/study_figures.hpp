#pragma once
// The figures of a study's report, as gnuplot scripts (plot.hpp).

#include <optional>
#include <string>
#include <vector>

#include "apps/picture/palette.hpp"
#include "apps/picture/report_figures.hpp"
#include "scheduling/study/study_ranking.hpp"

namespace forefeel {

// A value of a metric in the unit of its title.
double in_unit(const StudyMetric& metric, double value);
// False for an interval that says nothing: unknown, without width, or nearly as wide as all that the metric
// can be.
bool says_something(const StudyMetric& metric, const ConfidenceInterval& interval);

// The ranking of one axis; the axis of values fits the means and the bootstrap intervals. Nothing without a
// value.
std::optional<Figure> ranking_figure(const Study& study, const AxisRanking& entry, const Palette& palette);
// The first axis' values over an axis of numbers. Nothing if the axis has no two numbers.
std::optional<Figure> curves_figure(const Study& study, const std::vector<StudyCellResult>& cells,
                                    std::size_t axis, const Palette& palette);
// All of a report: rankings, then curves.
std::vector<Figure> study_figures(const Study& study, const std::vector<StudyCellResult>& cells,
                                  const std::vector<AxisRanking>& ranked, const Palette& palette);

}  // namespace forefeel
