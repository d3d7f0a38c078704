#include "scheduling/record/summary_columns.hpp"

#include <cmath>
#include <string_view>
#include <utility>

namespace forefeel {
namespace {

// Values under one key, each named "key.name".
class Group {
 public:
  Group(std::vector<Column>& columns, std::string key) : columns_(columns), prefix_(std::move(key) + ".") {}
  Group& number(std::string_view name, double value) { return put(name, column_value(value)); }
  Group& count(std::string_view name, std::uint64_t value) { return put(name, value); }
  Group& flag(std::string_view name, bool value) { return put(name, value); }
  Group& text(std::string_view name, std::string_view value) { return put(name, std::string(value)); }

 private:
  Group& put(std::string_view name, ColumnValue value) {
    columns_.push_back({prefix_ + std::string(name), std::move(value)});
    return *this;
  }

  std::vector<Column>& columns_;
  std::string prefix_;
};

void add_timing(std::vector<Column>& columns, const std::string& key, const SessionSummary::Timing& timing) {
  Group(columns, key).number("p50", timing.p50).number("p99", timing.p99).number("max", timing.max);
}

void add_parts(std::vector<Column>& columns, const std::string& key, const SessionSummary::Parts& parts) {
  Group(columns, key)
      .number("approximation", parts.approximation)
      .number("switch", parts.switching)
      .number("staleness", parts.staleness);
}

void add_errors(std::vector<Column>& columns, const std::string& key, const SessionSummary::Errors& errors,
                bool with_max = true) {
  Group group(columns, key);
  group.count("samples", errors.samples).number("p50", errors.p50).number("p95", errors.p95);
  if (with_max) group.number("max", errors.max);
  group.number("within_jnd", errors.within_jnd);
}

void add_deadline(std::vector<Column>& columns, const SessionSummary::Deadline& deadline) {
  Group(columns, "deadline").count("missed", deadline.missed);
  add_timing(columns, "deadline.cost_us", deadline.cost_us);
  add_timing(columns, "deadline.lateness_us", deadline.lateness_us);
}

void add_states(std::vector<Column>& columns, const SessionSummary::States& states) {
  Group(columns, "states")
      .count("start", states.start)
      .count("solved", states.solved)
      .count("used", states.used)
      .count("wasted", states.wasted)
      .count("preempted", states.preempted)
      .count("failed", states.failed)
      .number("age_at_use_ms.p50", states.age_at_use_ms_p50)
      .number("age_at_use_ms.p99", states.age_at_use_ms_p99)
      .flag("foreign", states.foreign);
}

void add_switching(std::vector<Column>& columns, const SessionSummary::Switching& switching) {
  Group(columns, "switch")
      .count("count", switching.count)
      .text("rule", name(switching.rule))
      .number("max_jump", switching.max_jump)
      .number("max_jump_undamped", switching.max_jump_undamped)
      .count("frames_over_jnd", switching.frames_over_jnd)
      .number("drift.ms50", switching.drift_50ms)
      .number("drift.ms100", switching.drift_100ms)
      .number("drift.ms300", switching.drift_300ms);
}

void add_error(std::vector<Column>& columns, const SessionSummary::Error& error, bool foreign) {
  Group(columns, "error")
      .text("reference",
            foreign ? "none: the states are of another body" : "tight solves on the reference branch");
  add_errors(columns, "error", error.samples);
  add_parts(columns, "error.parts", error.parts_p95);
  add_parts(columns, "error.parts_p50", error.parts_p50);
  for (const Label label : all_labels)
    add_errors(columns, "error.by_label." + std::string(name(label)), error.by_label[label]);
  add_errors(columns, "error.first_visit", error.first_visit, false);
}

void add_safety(std::vector<Column>& columns, const SessionSummary::Safety& safety) {
  Group(columns, "safety")
      .count("clamped", safety.clamped)
      .count("slewed", safety.slewed)
      .count("stale", safety.stale)
      .count("non_finite", safety.non_finite);
}

void add_loop(std::vector<Column>& columns, const SessionSummary::Loop& loop) {
  Group(columns, "loop")
      .count("skipped", loop.skipped)
      .number("longest_pause", loop.longest_pause)
      .number("planner_stall", loop.planner_stall)
      .count("ending_frames", loop.ending_frames)
      .number("last_force", loop.last_force);
}

}  // namespace

ColumnValue column_value(double value) {
  return std::isfinite(value) ? ColumnValue(value) : ColumnValue();
}

std::vector<Column> later_columns(const SessionSummary& summary) {
  std::vector<Column> columns;
  columns.push_back({"states.inverted", std::uint64_t{summary.states.inverted}});
  Group(columns, "safety")
      .number("clamped_share", summary.safety.clamped_share)
      .number("slewed_share", summary.safety.slewed_share);
  columns.push_back({"time_outside", column_value(summary.motion.outside)});
  Group(columns, "start")
      .number("reference", summary.motion.start_reference)
      .number("rendered", summary.motion.start_rendered)
      .number("within_jnd_at", summary.motion.start_within_jnd);
  return columns;
}

std::vector<Column> summary_columns(const SessionSummary& summary) {
  const auto& [settings, run, deadline, states, time_in, switching, error, load, energy, safety, loop,
               motion] = summary;
  std::vector<Column> columns;
  columns.push_back({"clock", std::string(settings.clock == Clock::real ? "real" : "virtual")});
  columns.push_back({"seconds", column_value(run.seconds)});
  columns.push_back({"frames", std::uint64_t{run.frames}});
  add_deadline(columns, deadline);
  add_states(columns, states);
  Group shares(columns, "time_in");
  for (const Label label : all_labels) shares.number(name(label), time_in[label]);
  add_switching(columns, switching);
  add_error(columns, error, states.foreign);
  columns.push_back({"load", column_value(load)});
  Group(columns, "energy").number("generated_J", energy.generated).number("work_J", energy.work);
  add_safety(columns, safety);
  add_loop(columns, loop);
  columns.push_back({"workers", static_cast<std::uint64_t>(settings.workers)});
  columns.push_back({"policy", settings.policy});
  columns.push_back({"select", std::string(name(settings.select))});
  columns.push_back({"seed", settings.seed});
  columns.push_back({"device", settings.device});
  columns.push_back({"first_guess", run.first_guess});
  columns.push_back({"first_guess_softness", column_value(run.guess_softness)});
  columns.push_back({"wall_seconds", column_value(run.wall_seconds)});
  columns.push_back({"realtime_priority", run.realtime_priority});
  columns.push_back({"memory_locked", run.memory_locked});
  for (Column& column : later_columns(summary)) columns.push_back(std::move(column));
  return columns;
}

}  // namespace forefeel
