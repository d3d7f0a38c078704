#pragma once
// What a study shows: for each axis, which value is better, by how much, and how sure that is.
// The unit of evidence is a trace with a seed. Whatever else varies is averaged within it, and only where
// every value that is compared has a result, so that many settings of one recording do not pass for many
// recordings.

#include <optional>
#include <string>
#include <vector>

#include "scheduling/study/cell_result.hpp"
#include "scheduling/study/statistics.hpp"
#include "scheduling/study/study.hpp"

namespace forefeel {

struct StudyMetric {
  std::string key;    // column of a cell's result
  std::string title;  // for people, with unit
  bool larger_is_better = true;
  double scale = 1;    // the title's unit per SI unit
  bool ratio = false;  // compared by factors: differences are those of the logarithm
  bool share = false;  // lies in [0, 1], and so do the intervals of its means
};

StudyMetric primary_metric(const Study& study);  // first visits within the JND, or the sustained speed
// Error of first visits, compared by factors. It still tells values apart where nearly all first visits are
// within the JND.
StudyMetric second_metric(const Study& study);
std::vector<StudyMetric> study_metrics(const Study& study);  // the primary first

// One value of another axis: only cells with it count.
struct StudySlice {
  std::size_t axis = 0, value = 0;
};

std::vector<Observation> observations(const Study& study, const std::vector<StudyCellResult>& cells,
                                      std::size_t axis, const StudyMetric& metric,
                                      const std::vector<StudySlice>& slices = {});

struct AxisRanking {
  std::size_t axis = 0;
  StudyMetric metric;
  Ranking ranking;
};
// Of each axis with at least two values.
std::vector<AxisRanking> rankings(const Study& study, const std::vector<StudyCellResult>& cells);

// The first axis' value `a` against `b`, over everything or in one slice. Means are differences, or
// logarithms of factors where the metric is compared by factors.
struct Contrast {
  StudyMetric metric;
  std::size_t a = 0, b = 0;
  std::optional<StudySlice> slice;
  Comparison comparison;
};
// Of steps: each against the one before. With a baseline, and for other axes without one against the best
// over all: each value against it, over everything and at each value of every other axis but the traces.
std::vector<Contrast> contrasts(const Study& study, const std::vector<StudyCellResult>& cells,
                                const StudyMetric& metric);

// Adds to each cell, where the policy `clairvoyant` is among what varies, how much less it has than the cell
// that differs in the policy alone and is clairvoyant:
//   regret.within_jnd, regret.first_visit.within_jnd
// The clairvoyant policy takes the best of the schedules it rehearses: every policy but the placebos. Only a
// policy that it does not know can have a regret below zero.
void add_regret(const Study& study, std::vector<StudyCellResult>& cells);

}  // namespace forefeel
