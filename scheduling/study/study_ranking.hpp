#pragma once
// Evaluates a study: for each axis, which value is better, by how much, and with which confidence. One observation is a
// trace with a seed. Within it the other axes are averaged, over those settings where all compared values have a
// result. So one recording under many settings does not count as many recordings.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scheduling/study/cell_result.hpp"
#include "scheduling/study/statistics.hpp"
#include "scheduling/study/study.hpp"

namespace forefeel {

struct StudyMetric {
  std::string key;    // column of a cell's result
  std::string title;  // as printed, with unit
  bool larger_is_better = true;
  double scale = 1;    // the title's unit per SI unit
  bool ratio = false;  // compared by factors: differences are those of the logarithm
  bool share = false;  // lies in [0, 1], like the intervals of its means
};

StudyMetric primary_metric(const Study& study);  // first visits within the JND, or the sustained speed
// Error of first visits, compared by factors. It still distinguishes values when nearly all first visits are
// within the JND.
StudyMetric second_metric(const Study& study);
std::vector<StudyMetric> compared_metrics(const Study& study);  // these two, and the error in newtons
std::vector<StudyMetric> study_metrics(const Study& study);     // the primary first

// Restricts an evaluation to the cells with this value of another axis.
struct StudySlice {
  std::size_t axis = 0, value = 0;
};

std::vector<Observation> observations(const Study& study, const std::vector<StudyCellResult>& cells,
                                      std::size_t axis, const StudyMetric& metric,
                                      const std::vector<StudySlice>& slices = {});

// Below this number of motions no interval is given and nothing is significant: how much motions differ is not known.
inline constexpr std::size_t fewest_motions = 4;

// bound: a policy that knows the motion (clairvoyant …), which no real policy reaches. placebo: is_placebo().
// Neither competes.
enum class Standing : std::uint8_t { contender, placebo, bound };
Standing standing_of(const StudyAxis& axis, std::size_t level);

// The values of an axis, best first, those that do not compete last.
LevelRanking ranking_of(const Study& study, const std::vector<StudyCellResult>& cells, std::size_t axis,
                        const StudyMetric& metric, const std::vector<StudySlice>& slices = {});
// The order of table, report, picture and verdict: that of ranking_of() by the primary metric, then what is not ranked.
std::vector<std::size_t> ranked_levels(const Study& study, const std::vector<StudyCellResult>& cells,
                                       std::size_t axis);

struct AxisRanking {
  std::size_t axis = 0;
  StudyMetric metric;
  LevelRanking ranking;
};
// Nemenyi's, of the values that compete over all motions; NaN below fewest_motions.
double critical_difference(const AxisRanking& ranking);
// The ranking of each axis with at least two values; of motions only where nothing else varies, since each has its own
// load.
std::vector<AxisRanking> rankings(const Study& study, const std::vector<StudyCellResult>& cells);

// The first axis' value `a` against `b`, over everything or in one slice. Means are differences, or
// logarithms of factors where the metric is compared by factors.
struct Contrast {
  StudyMetric metric;
  std::size_t a = 0, b = 0;
  std::optional<StudySlice> slice;
  Comparison comparison;
  double holm = 1;  // p value, adjusted over all contrasts with this metric and slice; NaN without one
  // As comparison.verdict(), but 0 also where the adjusted p value exceeds `significant`.
  int verdict() const { return holm <= significant ? comparison.verdict() : 0; }
};
// If the first axis is `step`: each value against the one before. For other axes, and for `step` with a
// baseline: each value against the baseline or, without one, against the best over all. These compare all
// cells, and the cells at each value of every other axis except traces; in the order of ranked_levels().
std::vector<Contrast> contrasts(const Study& study, const std::vector<StudyCellResult>& cells,
                                const StudyMetric& metric);

// If the study varies the policy and includes `clairvoyant`: adds to each cell its deficit against the
// clairvoyant cell with otherwise the same settings:
//   regret.within_jnd, regret.first_visit.within_jnd
// The clairvoyant policy takes the best of the schedules that it simulates: those of every policy except the placebos.
// Only a policy that it does not simulate can have a negative regret.
void add_regret(const Study& study, std::vector<StudyCellResult>& cells);

}  // namespace forefeel
