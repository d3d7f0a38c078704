#include "scheduling/study/cell_result.hpp"

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

void add_parts(const SessionResult& result, StudyCellResult& row) {
  const std::pair<const char*, double Judgement::*> parts[] = {{"approximation", &Judgement::approximation},
                                                               {"switch", &Judgement::switching},
                                                               {"staleness", &Judgement::staleness}};
  for (const auto& [name, member] : parts) {
    std::vector<double> values;
    for (const FrameRecord& frame : result.frames)
      if (frame.judged.first_visit && std::isfinite(frame.judged.*member))
        values.push_back(frame.judged.*member);
    row.set(std::string("error.first_visit.parts.") + name,
            column_value(quantile_of(std::move(values), 0.95, QuantileRule::inverted_cdf)));
  }
}

// Solves still running at the end count as busy, not as wasted.
void add_solver_time(const SessionResult& result, double end, StudyCellResult& row) {
  double busy = 0, preempted = 0, wasted = 0;
  std::size_t solved = 0, used = 0;
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
  row.set("states.used_share",
          column_value(solved > 0 ? static_cast<double>(used) / static_cast<double>(solved) : unknown));
  row.set("solver.busy", column_value(busy));
  row.set("solver.preempted", column_value(preempted));
  row.set("solver.wasted", column_value(wasted));
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

std::vector<Declared> declared_cells() {
  std::vector<Declared> rows = declared_summary();
  const std::vector<Declared> of_studies{
      {"error.first_visit.parts.approximation", "1", "", "as error.parts.approximation, over first visits"},
      {"error.first_visit.parts.switch", "1", "", "as error.parts.switch, over first visits"},
      {"error.first_visit.parts.staleness", "1", "", "as error.parts.staleness, over first visits"},
      {"error.first_visit.within_7", "1", "", "share of first visits within 7 % of the reference force"},
      {"states.used_share", "1", "", "share of the solved states that some model used"},
      {"solver.busy", "s", "", "time of all workers in solves"},
      {"solver.preempted", "s", "", "of this, in solves that were cancelled"},
      {"solver.wasted", "s", "", "of this, in solves whose state no model used"},
      {"solver.busy_share", "1", "", "busy, as a share of the workers' time: 1 where they are saturated"},
      {"cost", "", "", "cost model of the solves"},
      {"motion_seconds", "s", "", "length of the motion itself; empty for one without end"},
      {"sustained.speed", "m/s", "", "highest speed sustained; 0: not even the lowest. [sustained] only"},
      {"sustained.capped", "", "", "true: the highest speed tried is sustained. [sustained] only"},
      {"sustained.trials", "", "", "speeds tried. [sustained] only"},
      {"regret.within_jnd", "1", "", "error.within_jnd of clairvoyant less that of this cell"},
      {"regret.first_visit.within_jnd", "1", "", "the same of error.first_visit.within_jnd"}};
  rows.insert(rows.end(), of_studies.begin(), of_studies.end());
  return rows;
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
  add_parts(result, row);
  row.set("error.first_visit.within_7", column_value(first_visits_within(result, options.switching, 0.07)));
  add_solver_time(result, options.clock.seconds, row);
  row.set("cost", to_text(options.workers.cost));
  for (const Column& column : later) row.set(column.name, column.value);
  const double capacity = options.clock.seconds * options.workers.count;
  row.set("solver.busy_share", column_value(row.number("solver.busy") / capacity));
  row.set_notes(shortened_notes(result.notes));
  return row;
}

}  // namespace forefeel
