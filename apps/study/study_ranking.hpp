#pragma once
// What a study shows: for each thing that varies, which value is better, by how much, and how sure that is.
// The unit of evidence is a trace with a seed: whatever else varies is averaged within it (only where every
// value compared has a result), so that many settings of one recording do not pass for many recordings.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/study/study_table.hpp"
#include "scheduling/study/statistics.hpp"

namespace forefeel {

struct StudyMetric {
  std::string key;    // column of cells.csv
  std::string title;  // for people, with unit
  bool larger_is_better = true;
  double scale = 1;    // title's unit per SI
  bool ratio = false;  // compared by factors: differences are those of the logarithm
  bool share = false;  // lies in [0, 1], and so do the intervals of its means
};

StudyMetric primary_metric(const Study& study);  // first visits within the JND, or the sustained speed
// Error of first visits, by factors: still tells values apart where nearly all first visits are within the
// JND.
StudyMetric second_metric(const Study& study);
std::vector<StudyMetric> study_metrics(const Study& study);  // the primary first

// Restricts to one value of another axis.
struct StudySlice {
  std::size_t axis = 0, value = 0;
};

std::vector<Observation> observations(const Study& study, const std::vector<CellColumns>& cells,
                                      std::size_t axis, const StudyMetric& metric,
                                      const std::vector<StudySlice>& slices = {});

struct AxisRanking {
  std::size_t axis = 0;
  StudyMetric metric;
  Ranking ranking;
};
std::vector<AxisRanking> rankings(const Study& study,
                                  const std::vector<CellColumns>& cells);  // axes of 2 values or more

// The first axis' value `a` against `b`, over everything or in one slice; means as differences, or as factors
// where the metric is compared so.
struct Contrast {
  StudyMetric metric;
  std::size_t a = 0, b = 0;
  std::optional<StudySlice> slice;
  Comparison comparison;
};
// Steps: each against the one before. Each value against the baseline (without one: steps not at all, others
// against the best over all), over everything and at each value of every other axis but the traces.
std::vector<Contrast> contrasts(const Study& study, const std::vector<CellColumns>& cells,
                                const StudyMetric& metric);

bool is_trace_axis(const StudyAxis& axis);
nlohmann::ordered_json ranking_json(const Study& study, const std::vector<AxisRanking>& rankings,
                                    const std::vector<Contrast>& contrasts);

}  // namespace forefeel
