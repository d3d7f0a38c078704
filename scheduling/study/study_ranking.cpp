#include "scheduling/study/study_ranking.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "scheduling/policy/policy.hpp"

namespace forefeel {
namespace {

// Value of the axis of traces, unless this is the axis itself.
std::size_t trace_of(const Study& study, std::span<const std::size_t> choice, std::size_t axis) {
  for (std::size_t i = 0; i < study.axes.size(); ++i)
    if (i != axis && is_trace_axis(study.axes[i])) return choice[i];
  return 0;
}

bool in_slices(std::span<const std::size_t> choice, const std::vector<StudySlice>& slices) {
  return std::ranges::all_of(slices,
                             [&](const StudySlice& slice) { return choice[slice.axis] == slice.value; });
}

double value_of(const Study& study, const StudyCellResult& cell, const StudyMetric& metric) {
  const double value = cell.number(metric.key);
  if (!metric.ratio) return value;
  // If even the lowest speed tried fails, the speed is zero. It is counted as the lowest speed, which favours that
  // value.
  const bool speed = metric.key == "sustained.speed" && study.sustained;
  return std::log(std::max(value, speed ? study.sustained->low : 1e-6));
}

std::vector<std::size_t> beside_contenders(const StudyAxis& axis) {
  std::vector<std::size_t> beside;
  for (std::size_t level = 0; level < axis.values.size(); ++level)
    if (standing_of(axis, level) != Standing::contender) beside.push_back(level);
  return beside;
}

// Adjusts the p values of one family of contrasts, from `first` on.
void adjust_family(std::vector<Contrast>& all, std::size_t first) {
  std::vector<double> p_values;
  for (std::size_t i = first; i < all.size(); ++i) p_values.push_back(all[i].comparison.p_value());
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t i = first; i < all.size(); ++i) all[i].holm = adjusted[i - first];
}

void drop_interval_of_few(Comparison& c) {
  if (c.groups >= fewest_motions) return;
  for (ConfidenceInterval* interval : {&c.student, &c.bootstrap})
    interval->low = interval->high = std::nan("");
}

}  // namespace

Standing standing_of(const StudyAxis& axis, std::size_t level) {
  if (axis.column != "policy" && axis.column != "session.policy") return Standing::contender;
  const std::string& policy = axis.values[level].text;
  if (is_placebo(policy)) return Standing::placebo;
  return policy.starts_with("clairvoyant") ? Standing::bound : Standing::contender;
}

StudyMetric primary_metric(const Study& study) {
  return study_metrics(study).front();
}

StudyMetric second_metric(const Study& study) {
  const std::vector<StudyMetric> all = study_metrics(study);
  return *std::ranges::find(all, std::string("error.first_visit.p95"), &StudyMetric::key);
}

std::vector<StudyMetric> compared_metrics(const Study& study) {
  const std::vector<StudyMetric> all = study_metrics(study);
  return {primary_metric(study), second_metric(study),
          *std::ranges::find(all, std::string("error.first_visit.p95_N"), &StudyMetric::key)};
}

std::vector<StudyMetric> study_metrics(const Study& study) {
  std::vector<StudyMetric> metrics;
  if (study.sustained) metrics.push_back({"sustained.speed", "sustained HIP speed [mm/s]", true, 1e3, true});
  const std::vector<StudyMetric> of_sessions{
      {"error.first_visit.within_jnd", "first visits within the JND [%]", true, 100, false, true},
      {"error.within_jnd", "all samples within the JND [%]", true, 100, false, true},
      {"error.first_visit.p95", "error of first visits, p95 [%]", false, 100, true},
      {"error.first_visit.p95_N", "error of first visits, p95 [mN]", false, 1e3},
      {"error.p95", "error, p95 [%]", false, 100},
      {"error.first_visit.parts.approximation", "approximation at first visits, p95 [%]", false, 100},
      {"error.first_visit.parts.switch", "switch at first visits, p95 [%]", false, 100},
      {"error.first_visit.parts.staleness", "staleness at first visits, p95 [%]", false, 100},
      {"error.parts.approximation", "approximation, p95 [%]", false, 100},
      {"error.parts.switch", "switch, p95 [%]", false, 100},
      {"error.parts.staleness", "staleness, p95 [%]", false, 100},
      {"time_in.safe", "time in safe [%]", true, 100, false, true},
      {"time_in.blank", "time in blank [%]", false, 100, false, true},
      {"states.age_at_use_ms.p50", "age at first use, median [ms]", false},
      {"states.used_share", "solved states used [%]", true, 100, false, true},
      {"solver.preempted", "solver time in cancelled solves [s]", false},
      {"solver.wasted", "solver time for states never used [s]", false},
      {"regret.first_visit.within_jnd", "regret at first visits [points]", false, 100},
      {"load", "load (needed over solved states per second)", false},
      {"solver.busy_share", "saturation: time that workers solve [%]", false, 100, false, true},
      {"energy.generated_J", "energy given back beyond that received [mJ]", false, 1e3},
      {"safety.clamped_share", "frames clamped at the force limit [%]", false, 100, false, true},
      {"safety.slewed_share", "frames at the slew limit [%]", false, 100, false, true},
      {"time_outside", "time outside the box of states [%]", false, 100, false, true},
      {"states.inverted", "states with inverted elements", false},
      {"prediction.ms100.p95", "error of the prediction 0.1 s ahead, p95 [mm]", false, 1e3},
      {"prediction.ms100.within_50", "true places in the ball of 50 % so far ahead [%]", true, 100, false,
       true},
      {"prediction.ms100.within_90", "true places in the ball of 90 % so far ahead [%]", true, 100, false,
       true},
      {"error.first_visit.samples", "first visits in a session", true},
      {"error.samples", "samples of the error in a session", true}};
  metrics.insert(metrics.end(), of_sessions.begin(), of_sessions.end());
  return metrics;
}

std::vector<Observation> observations(const Study& study, const std::vector<StudyCellResult>& cells,
                                      std::size_t axis, const StudyMetric& metric,
                                      const std::vector<StudySlice>& slices) {
  const std::size_t levels = study.axes[axis].values.size();
  const std::vector<std::size_t> blocks = blocks_without(study, axis);
  struct FineBlock {  // one block: everything but the axis is the same
    std::vector<double> values;
    std::pair<std::size_t, std::size_t> unit;  // trace, seed
  };
  std::map<std::size_t, FineBlock> fine;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::vector<std::size_t> choice = study.choice(study.combination_of(i));
    if (!in_slices(choice, slices)) continue;
    FineBlock& block = fine[blocks[i]];
    block.values.resize(levels, std::nan(""));
    block.values[choice[axis]] = value_of(study, cells[i], metric);
    block.unit = {trace_of(study, choice, axis), i % study.seeds.size()};
  }
  struct Unit {
    std::vector<double> sums;
    std::size_t complete = 0;
  };
  std::map<std::pair<std::size_t, std::size_t>, Unit> units;
  for (const auto& [id, block] : fine) {
    Unit& unit = units[block.unit];
    unit.sums.resize(levels, 0.0);
    if (!std::ranges::all_of(block.values, [](double v) { return std::isfinite(v); })) continue;
    ++unit.complete;
    for (std::size_t level = 0; level < levels; ++level) unit.sums[level] += block.values[level];
  }
  std::vector<Observation> seen;
  std::size_t number_of_unit = 0;
  for (const auto& [id, unit] : units) {
    for (std::size_t level = 0; level < levels; ++level)
      seen.push_back({.level = level,
                      .block = number_of_unit,
                      .group = id.first,
                      .value = unit.complete > 0 ? unit.sums[level] / static_cast<double>(unit.complete)
                                                 : std::nan("")});
    ++number_of_unit;
  }
  return seen;
}

LevelRanking ranking_of(const Study& study, const std::vector<StudyCellResult>& cells, std::size_t axis,
                        const StudyMetric& metric, const std::vector<StudySlice>& slices) {
  LevelRanking ranking =
      rank(observations(study, cells, axis, metric, slices), study.axes[axis].values.size(),
           metric.larger_is_better, {.shares = metric.share}, beside_contenders(study.axes[axis]));
  for (Ranked& row : ranking.ranked) {
    drop_interval_of_few(row.value);
    drop_interval_of_few(row.to_best);
  }
  adjust(ranking, beside_contenders(study.axes[axis]));
  return ranking;
}

std::vector<std::size_t> ranked_levels(const Study& study, const std::vector<StudyCellResult>& cells,
                                       std::size_t axis) {
  std::vector<std::size_t> order;
  for (const Ranked& row : ranking_of(study, cells, axis, primary_metric(study)).ranked)
    order.push_back(row.level);
  for (std::size_t level = 0; level < study.axes[axis].values.size(); ++level)
    if (std::ranges::find(order, level) == order.end()) order.push_back(level);
  return order;
}

double critical_difference(const AxisRanking& ranking) {
  const std::vector<Ranked>& ranked = ranking.ranking.ranked;
  if (ranked.empty() || ranked.front().value.groups < fewest_motions) return std::nan("");
  const auto compete =
      std::ranges::count_if(ranked, [](const Ranked& row) { return std::isfinite(row.mean_rank); });
  return critical_difference(static_cast<std::size_t>(compete), ranked.front().value.groups);
}

std::vector<AxisRanking> rankings(const Study& study, const std::vector<StudyCellResult>& cells) {
  std::vector<AxisRanking> all;
  const StudyMetric metric = primary_metric(study);
  const bool motions_alone = std::ranges::all_of(
      study.axes, [](const StudyAxis& axis) { return axis.values.size() < 2 || is_trace_axis(axis); });
  for (std::size_t axis = 0; axis < study.axes.size(); ++axis)
    if (study.axes[axis].values.size() > 1 && (motions_alone || !is_trace_axis(study.axes[axis])))
      all.push_back({axis, metric, ranking_of(study, cells, axis, metric)});
  return all;
}

std::vector<Contrast> contrasts(const Study& study, const std::vector<StudyCellResult>& cells,
                                const StudyMetric& metric) {
  std::vector<Contrast> all;
  if (study.axes.empty() || study.axes.front().values.size() < 2) return all;
  const std::vector<Observation> whole = observations(study, cells, 0, metric);
  const auto compared = [](const std::vector<Observation>& seen, std::size_t a, std::size_t b) {
    Comparison c = compare_levels(seen, a, b);
    drop_interval_of_few(c);
    return c;
  };
  if (study.axes.front().column == "step") {
    for (std::size_t level = 1; level < study.axes.front().values.size(); ++level)
      all.push_back({metric, level, level - 1, {}, compared(whole, level, level - 1)});
    adjust_family(all, 0);
    if (!study.baseline) return all;
  }
  const std::vector<std::size_t> order = ranked_levels(study, cells, 0);
  std::size_t reference = study.baseline.value_or(0);
  if (!study.baseline) {
    const LevelRanking ranking = ranking_of(study, cells, 0, metric);
    if (!ranking.ranked.empty()) reference = ranking.ranked.front().level;
  }
  const auto add = [&](std::optional<StudySlice> slice) {
    const std::vector<Observation> seen = slice ? observations(study, cells, 0, metric, {*slice}) : whole;
    const std::size_t first = all.size();
    for (const std::size_t level : order)
      if (level != reference)
        all.push_back({metric, level, reference, slice, compared(seen, level, reference)});
    adjust_family(all, first);
  };
  add({});
  for (std::size_t axis = 1; axis < study.axes.size(); ++axis)
    for (std::size_t value = 0; value < study.axes[axis].values.size(); ++value)
      if (!is_trace_axis(study.axes[axis]) && study.axes[axis].values.size() > 1)
        add(StudySlice{axis, value});
  return all;
}

void add_regret(const Study& study, std::vector<StudyCellResult>& cells) {
  std::optional<std::size_t> axis = find_axis(study, "policy");
  if (!axis) axis = find_axis(study, "session.policy");
  if (!axis) return;
  const std::vector<StudyValue>& policies = study.axes[*axis].values;
  const auto best = std::ranges::find(policies, std::string("clairvoyant"), &StudyValue::text);
  if (best == policies.end()) return;
  const std::vector<std::size_t> blocks = blocks_without(study, *axis);
  std::map<std::size_t, std::size_t> bound;  // block -> cell of the clairvoyant policy
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (study.choice(study.combination_of(i))[*axis] == static_cast<std::size_t>(best - policies.begin()))
      bound[blocks[i]] = i;
  for (const std::string key : {"within_jnd", "first_visit.within_jnd"})
    for (std::size_t i = 0; i < cells.size(); ++i)
      cells[i].set("regret." + key, column_value(cells[bound.at(blocks[i])].number("error." + key) -
                                                 cells[i].number("error." + key)));
}

}  // namespace forefeel
