#include "scheduling/study/cell_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/common/quantiles.hpp"
#include "scheduling/record/notes.hpp"
#include "scheduling/session/session_input.hpp"

namespace forefeel {
namespace {

bool depends_on_wall_time(std::string_view name) {
  return name.starts_with("deadline.cost_us") || name.starts_with("deadline.lateness_us") ||
         name == "loop.longest_pause" || name == "loop.planner_stall" || name == "loop.skipped" ||
         name == "wall_seconds" || name == "realtime_priority" || name == "memory_locked";
}

// 95th percentile of a part of the error over first visits.
ColumnValue part_of_error(const SessionResult& result, double Judgement::*part) {
  std::vector<double> values;
  for (const FrameRecord& frame : result.frames)
    if (frame.judged.first_visit && std::isfinite(frame.judged.*part)) values.push_back(frame.judged.*part);
  return column_value(quantile_of(std::move(values), 0.95, QuantileRule::inverted_cdf));
}

// 95th percentile of the error of the force over first visits [N].
ColumnValue force_error(const SessionResult& result) {
  std::vector<double> errors;
  for (const FrameRecord& frame : result.frames)
    if (frame.judged.first_visit && frame.judged.reference.allFinite())
      errors.push_back((compared_force(frame) - frame.judged.reference).norm());
  return column_value(quantile_of(std::move(errors), 0.95, QuantileRule::inverted_cdf));
}

// Time of the workers [s]. Solves still running at the end count as busy, not as wasted.
struct SolverTime {
  double busy = 0, preempted = 0, wasted = 0;
  std::size_t solved = 0, used = 0;

  SolverTime(const SessionResult& result, double end) {
    for (const DispatchRecord& job : result.dispatch) {
      if (!std::isfinite(job.started) || job.status == DispatchStatus::arrived) continue;
      const double seconds =
          std::max(0.0, std::min(std::isfinite(job.finished) ? job.finished : end, end) - job.started);
      busy += seconds;
      if (job.status == DispatchStatus::preempted) preempted += seconds;
      if (job.status != DispatchStatus::solved) continue;
      ++solved;
      used += std::isfinite(job.first_used) ? 1 : 0;
      wasted += std::isfinite(job.first_used) ? 0 : seconds;
    }
  }
  double used_share() const {
    return solved > 0 ? static_cast<double>(used) / static_cast<double>(solved) : unknown;
  }
};

// The columns that only studies have, before and after the last ones of the summary.
std::vector<Column> columns_of_session(const SessionResult& result, const SessionOptions& options) {
  const SolverTime time(result, options.clock.seconds);
  return {{"error.first_visit.parts.approximation", part_of_error(result, &Judgement::approximation), "1",
           "as error.parts.approximation, over first visits"},
          {"error.first_visit.parts.switch", part_of_error(result, &Judgement::switching), "1",
           "as error.parts.switch, over first visits"},
          {"error.first_visit.parts.staleness", part_of_error(result, &Judgement::staleness), "1",
           "as error.parts.staleness, over first visits"},
          {"error.first_visit.within_7", column_value(first_visits_within(result, options.switching, 0.07)),
           "1", "share of first visits within 7 % of the reference force"},
          {"states.used_share", column_value(time.used_share()), "1",
           "share of the solved states that some model used"},
          {"solver.busy", column_value(time.busy), "s", "time of all workers in solves"},
          {"solver.preempted", column_value(time.preempted), "s", "of this, in solves that were cancelled"},
          {"solver.wasted", column_value(time.wasted), "s", "of this, in solves whose state no model used"},
          {"cost", to_text(options.workers.cost), "", "cost model of the solves"}};
}
std::vector<Column> columns_of_prediction(const std::vector<PredictionError>& errors) {
  std::vector<Column> columns;
  for (const PredictionError& e : errors) {
    const bool compared = e.p95 > 0;
    const auto add = [&](const char* name, double value, const char* unit, const char* meaning) {
      columns.push_back({fmt::format("prediction.ms{:.0f}.{}", 1e3 * e.horizon, name),
                         column_value(compared ? value : unknown), unit, meaning});
    };
    add("p95", e.p95, "m",
        "95th percentile of |predicted - true position|, so far ahead, of the cell's predictor");
    add("within_50", e.within_50, "1", "share of true positions in the ball that should hold 50 % of them");
    add("within_90", e.within_90, "1", "the same for 90 %");
  }
  return columns;
}

std::vector<Column> last_columns(const SessionResult& result, const SessionOptions& options) {
  const double capacity = options.clock.seconds * options.workers.count;
  return {{"solver.busy_share", column_value(SolverTime(result, options.clock.seconds).busy / capacity), "1",
           "busy, as a share of the workers' time: 1 where they are saturated"},
          {"error.first_visit.p95_N", force_error(result), "N",
           "95th percentile of |rendered - reference| over first visits"}};
}

}  // namespace

const ColumnValue* StudyCellResult::find(std::string_view name) const {
  const auto found = std::ranges::find(columns_, name, &Column::name);
  return found == columns_.end() ? nullptr : &found->value;
}

double StudyCellResult::number(std::string_view name) const {
  const ColumnValue* value = find(name);
  if (!value) return unknown;
  if (const auto* whole = std::get_if<std::uint64_t>(value)) return static_cast<double>(*whole);
  const auto* real = std::get_if<double>(value);
  return real ? *real : unknown;
}

void StudyCellResult::set(std::string_view name, ColumnValue value) {
  const auto found = std::ranges::find(columns_, name, &Column::name);
  if (found != columns_.end())
    found->value = std::move(value);
  else
    columns_.push_back({std::string(name), std::move(value)});
}

void add_prediction(const std::vector<PredictionError>& errors, StudyCellResult& row) {
  for (const Column& column : columns_of_prediction(errors)) row.set(column.name, column.value);
}

DeclaredTable cells_output() {
  std::vector<Column> columns = summary_columns({});
  for (Column& column : columns_of_session({}, {})) columns.push_back(std::move(column));
  for (Column& column : last_columns({}, {})) columns.push_back(std::move(column));
  std::vector<PredictionError> by_horizon;
  for (const double horizon : score_horizons) by_horizon.push_back({.horizon = horizon});
  for (Column& column : columns_of_prediction(by_horizon)) columns.push_back(std::move(column));
  DeclaredTable table{
      "cells.csv",
      "One row a cell of a study: a column for each varied key, seed, then these. pandas.read_csv reads "
      "it, and read.csv(check.names = FALSE) in R; melt() makes a row for each measure.",
      declared_columns(columns)};
  const std::vector<Declared> of_studies{
      {"motion_seconds", "s", "", "length of the motion itself; empty for one without end"},
      {"sustained.speed", "m/s", "", "highest speed sustained; 0: not even the lowest. [sustained] only"},
      {"sustained.capped", "", "", "true: the highest speed tried is sustained. [sustained] only"},
      {"sustained.trials", "", "", "speeds tried. [sustained] only"},
      {"regret.within_jnd", "1", "", "error.within_jnd of clairvoyant less that of this cell"},
      {"regret.first_visit.within_jnd", "1", "", "the same of error.first_visit.within_jnd"}};
  table.rows.insert(table.rows.end(), of_studies.begin(), of_studies.end());
  return table;
}

std::vector<std::string> notes_of(std::span<const StudyCellResult> cells) {
  std::vector<std::vector<std::string>> notes;
  for (const StudyCellResult& cell : cells) notes.push_back(cell.notes());
  return notes_in_common(notes);
}

double first_visits_within(const SessionResult& result, const SwitchOptions& jnd, double tolerance) {
  std::size_t visits = 0, within = 0;
  for (const FrameRecord& frame : result.frames) {
    if (!frame.judged.first_visit || !frame.judged.reference.allFinite()) continue;
    ++visits;
    const double allowed = std::max(tolerance * frame.judged.reference.norm(), jnd.jnd_floor);
    within += (frame.force - frame.judged.reference).norm() <= allowed ? 1 : 0;
  }
  return visits > 0 ? static_cast<double>(within) / static_cast<double>(visits) : unknown;
}

StudyCellResult cell_result(const SessionResult& result, const SessionInput& input,
                            const SessionOptions& options) {
  const SessionSummary summary = summarise(result, input, options);
  const std::vector<Column> later = later_columns(summary);  // the last columns; they follow the study's own
  std::vector<Column> columns = summary_columns(summary);
  columns.resize(columns.size() - later.size());
  StudyCellResult row(std::move(columns));
  for (const Column& column : row.columns())
    if (depends_on_wall_time(column.name)) row.set(column.name, {});
  for (const std::vector<Column>& more :
       {columns_of_session(result, options), later, last_columns(result, options)})
    for (const Column& column : more) row.set(column.name, column.value);
  row.set_notes(shortened_notes(result.notes));
  return row;
}

}  // namespace forefeel
