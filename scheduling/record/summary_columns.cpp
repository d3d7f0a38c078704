#include "scheduling/record/summary_columns.hpp"

#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

namespace forefeel {
namespace {

// Values under one key, each named "key.name", with unit and meaning.
class Group {
 public:
  using Text = std::string_view;
  Group(std::vector<Column>& columns, const std::string& key)
      : columns_(columns), prefix_(key.empty() ? key : key + ".") {}
  Group& number(Text name, double value, Text unit, Text meaning) {
    return put(name, column_value(value), unit, meaning);
  }
  Group& count(Text name, std::uint64_t value, Text meaning) { return put(name, value, "", meaning); }
  Group& flag(Text name, bool value, Text meaning) { return put(name, value, "", meaning); }
  Group& text(Text name, Text value, Text meaning) { return put(name, std::string(value), "", meaning); }
  Group& label(Text name, std::optional<Label> value, Text meaning) {
    return put(name, value ? ColumnValue(std::string(forefeel::name(*value))) : ColumnValue(), "", meaning);
  }

 private:
  Group& put(Text name, ColumnValue value, Text unit, Text meaning) {
    columns_.push_back({prefix_ + std::string(name), std::move(value), unit, meaning});
    return *this;
  }

  std::vector<Column>& columns_;
  std::string prefix_;
};

void add_timing(std::vector<Column>& columns, const std::string& key, const SessionSummary::Timing& timing) {
  Group(columns, key)
      .number("p50", timing.p50, "us", "median over the frames; real clock only, also below")
      .number("p99", timing.p99, "us", "99th percentile")
      .number("max", timing.max, "us", "largest");
}

void add_parts(std::vector<Column>& columns, const std::string& key, const SessionSummary::Parts& parts) {
  Group(columns, key)
      .number("approximation", parts.approximation, "1", "error of the newest model against the reference")
      .number("switch", parts.switching, "1", "rendered force against the newest model")
      .number("staleness", parts.staleness, "1", "newest model against one of all states known by then");
}

void add_errors(std::vector<Column>& columns, const std::string& key, const SessionSummary::Errors& errors,
                bool with_max = true) {
  Group group(columns, key);
  group.count("samples", errors.samples, "frames in which the rendered force was compared with a tight solve")
      .number("p50", errors.p50, "1", "median error, relative to max(|reference|, session.error_floor)")
      .number("p95", errors.p95, "1", "95th percentile of the error");
  if (with_max) group.number("max", errors.max, "1", "largest error");
  group.number("within_jnd", errors.within_jnd, "1",
               "share of the samples with an error below the just noticeable difference");
}

void add_deadline(std::vector<Column>& columns, const SessionSummary::Deadline& deadline) {
  Group(columns, "deadline")
      .count("missed", deadline.missed, "frames whose cost and lateness together exceed their length");
  add_timing(columns, "deadline.cost_us", deadline.cost_us);
  add_timing(columns, "deadline.lateness_us", deadline.lateness_us);
}

void add_states(std::vector<Column>& columns, const SessionSummary::States& states) {
  Group(columns, "states")
      .count("start", states.start, "states known at the start")
      .count("solved", states.solved, "states solved in the session")
      .count("used", states.used, "of these, states that some model used")
      .count("wasted", states.wasted, "of these, states that no model used")
      .count("preempted", states.preempted, "solves cancelled while they ran")
      .count("failed", states.failed, "solves without an equilibrium")
      .number("age_at_use_ms.p50", states.age_at_use_ms_p50, "ms",
              "median time from the end of a solve to the first use of its state")
      .number("age_at_use_ms.p99", states.age_at_use_ms_p99, "ms", "99th percentile of that time")
      .flag("foreign", states.foreign, "true: the states are of another body, nothing was solved");
}

void add_switching(std::vector<Column>& columns, const SessionSummary::Switching& switching) {
  Group(columns, "switch")
      .count("count", switching.count, "models that the loop took")
      .text("rule", name(switching.rule), "rule of the switch (session.switch)")
      .number("max_jump", switching.max_jump, "N",
              "largest change of the rendered force by a switch, per frame")
      .number("max_jump_undamped", switching.max_jump_undamped, "N", "the same if models changed at once")
      .count("frames_over_jnd", switching.frames_over_jnd,
             "frames in which a switch exceeded its rule's bound")
      .number("drift.ms50", switching.drift_50ms, "N", "largest change by switches within any 50 ms")
      .number("drift.ms100", switching.drift_100ms, "N", "within any 100 ms")
      .number("drift.ms300", switching.drift_300ms, "N", "within any 300 ms");
}

void add_error(std::vector<Column>& columns, const SessionSummary::Error& error, bool foreign) {
  Group(columns, "error")
      .text("reference",
            foreign ? "none: the states are of another body" : "tight solves on the reference branch",
            "what the rendered force is compared with");
  add_errors(columns, "error", error.samples);
  add_parts(columns, "error.parts", error.parts_p95);
  add_parts(columns, "error.parts_p50", error.parts_p50);
  for (const Label label : all_labels)
    add_errors(columns, "error.by_label." + std::string(name(label)), error.by_label[label]);
  add_errors(columns, "error.first_visit", error.first_visit, false);
}

void add_trust(std::vector<Column>& columns, const SessionSummary::Error& error) {
  Group(columns, "")
      .number("time_trusted", error.time_trusted, "1",
              "share of the frames whose force is that of energy jets within their trust");
  add_errors(columns, "error.by_trusted.no", error.by_trust[0]);
  add_errors(columns, "error.by_trusted.yes", error.by_trust[1]);
}

void add_bars(std::vector<Column>& columns, const std::string& key, const SessionSummary::Bars& bars) {
  Group(columns, key)
      .count("samples", bars.samples, "frames with an error bar that were compared with a tight solve")
      .number("coverage.p90", bars.inside[0], "1", "share of them inside the bar of 90 %")
      .number("coverage.p95", bars.inside[1], "1", "of 95 %")
      .number("coverage.p99", bars.inside[2], "1", "of 99 %")
      .number("width_p50", bars.width_p50, "N", "median half-width of the bar of 95 %")
      .number("error_p95", bars.error_p95, "N", "95th percentile of |rendered - reference|")
      .number("width_over_p95", bars.width_over_p95, "1", "width_p50 / error_p95");
}

void add_error_bars(std::vector<Column>& columns, const SessionSummary::ErrorBars& bars) {
  add_bars(columns, "error_bar", bars.all);
  Group(columns, "error_bar")
      .count("without", bars.without, "compared frames without a bar: no model had states")
      .count("at_floor.p90", bars.at_floor[0],
             "samples whose bar of 90 % is at its floor, a tenth of the just noticeable difference")
      .count("at_floor.p95", bars.at_floor[1], "of 95 %")
      .count("at_floor.p99", bars.at_floor[2], "of 99 %")
      .number("above_floor.p90", bars.inside_above[0], "1", "share inside of the samples above the floor")
      .number("above_floor.p95", bars.inside_above[1], "1", "of 95 %")
      .number("above_floor.p99", bars.inside_above[2], "1", "of 99 %");
  for (const Label label : all_labels)
    add_bars(columns, "error_bar.by_label." + std::string(name(label)), bars.by_label[label]);
}

void add_safety(std::vector<Column>& columns, const SessionSummary::Safety& safety) {
  Group(columns, "safety")
      .count("clamped", safety.clamped, "frames cut at the force limit")
      .count("slewed", safety.slewed, "frames held back by the slew limit")
      .count("stale", safety.stale, "frames in which the watchdog faded the force out")
      .count("non_finite", safety.non_finite, "frames whose force was not finite and counted as zero");
}

void add_loop(std::vector<Column>& columns, const SessionSummary::Loop& loop) {
  Group(columns, "loop")
      .count("skipped", loop.skipped, "frames that a pause of the loop skipped; real clock")
      .number("longest_pause", loop.longest_pause, "s", "longest time between two frames; real clock")
      .number("planner_stall", loop.planner_stall, "s", "longest silence of the planner; real clock")
      .count("ending_frames", loop.ending_frames,
             "last frames, in which the force sent shrinks to zero at the slew limit")
      .number("last_force", loop.last_force, "N", "|force| sent in the last frame");
}

void add_faults(std::vector<Column>& columns, const SessionSummary::Faults& faults) {
  Group(columns, "faults")
      .count("states_set_aside", faults.states_set_aside,
             "solved or arrived states that cannot be of this body: not a number, or far too strong; also in "
             "states.failed")
      .count("workers_lost", faults.workers_lost, "times that a worker failed or did not answer; real clock")
      .count("planner_stalls", faults.planner_stalls,
             "times that the planner was silent for longer than session.limits.stale; real clock")
      .count("clock_steps", faults.clock_steps,
             "times that the clock of the day was set by over 50 ms; the loop's clock is another one")
      .count("device_held", faults.device_held,
             "frames in which the device's position was not finite and the last one was held")
      .count("device_jumps", faults.device_jumps, "frames in which the tip moved faster than 1 m/s");
}

void add_time_in(std::vector<Column>& columns, const ByLabel<double>& time_in) {
  Group shares(columns, "time_in");
  for (const Label label : all_labels)
    shares.number(name(label), time_in[label], "1", "share of the frames with this label at the tip");
}

void add_settings(std::vector<Column>& columns, const SessionSummary::Settings& settings,
                  const SessionSummary::Run& run) {
  Group(columns, "")
      .count("workers", static_cast<std::uint64_t>(settings.workers), "workers that solve")
      .text("policy", settings.policy, "rule that chose what was solved next")
      .text("select", name(settings.select), "rule that chose the neighbours")
      .count("seed", settings.seed, "seed of everything random")
      .text("cost_model", settings.cost,
            "time of a solve under the virtual clock, as written; empty: the real clock")
      .text("device", settings.device, "device as written; replay:RUN for a replay")
      .flag("first_guess", run.first_guess, "true: began with the stiffness at rest, by one factorisation")
      .number("first_guess_softness", run.guess_softness, "1",
              "of the body against a disc on a half-space: how many times softer it is")
      .number("wall_seconds", run.wall_seconds, "s", "time that the run took")
      .flag("realtime_priority", run.realtime_priority, "true: the system gave real-time priority")
      .flag("memory_locked", run.memory_locked, "true: the system locked the memory");
}

void add_stability(std::vector<Column>& columns, const SessionSummary& summary) {
  const HandNumbers& hand = summary.energy.hand;
  const std::optional<StabilityReport>& found = summary.energy.stability;
  const auto known = [&](double value) { return found ? value : unknown; };
  const StabilityReport s = found.value_or(StabilityReport{});
  columns.push_back({"stability.stable", found ? ColumnValue(s.stable) : ColumnValue(), "",
                     "true: no instability was found; stability.* is known for a simulated hand only"});
  Group group(columns, "stability");
  group.number("since", s.since, "s", "first moment that is not stable; empty: none")
      .number("generated_J", known(s.generated), "J",
              "most energy that the loop generated in any second, beyond the encoder's quantum")
      .number("frequency_hz", s.frequency, "Hz", "dominant frequency of the vibration, above 5 Hz")
      .number("clamped_share", known(summary.safety.clamped_share), "1", "frames cut at the force limit")
      .number("amplitude", known(s.amplitude), "m", "RMS of the vibration in the worst second")
      .number("growth", s.growth, "1", "growth of the vibration per period, if it grew over three")
      .number("put_in_J", known(s.put_in), "J", "energy that the hand put in")
      .number("given_back_J", known(s.given_back), "J", "energy that the hand got back")
      .number("hold_J", known(s.hold), "J",
              "energy added because a force is held for a frame; not in generated_J")
      .number("switches_J", known(s.by_switches), "J", "work of the switches: rendered less newest model")
      .number("switch_max_J", known(s.by_a_switch), "J", "largest work of one switch");
  for (const Label label : all_labels)
    group.number("generated_in." + std::string(name(label)), known(s.generated_in[label]), "J",
                 "energy generated by the loop under this label");
  group.number("grip", hand.grip, "N/m", "stiffness of the grip")
      .number("grip_damping", hand.damping, "N s/m", "damping of the grip")
      .number("mass", hand.mass, "kg", "of hand and device")
      .number("resolution", hand.resolution, "m", "of the device's positions")
      .number("device_stiffness", hand.stiffness, "N/m", "highest stiffness that the device can render");
}

void add_control(std::vector<Column>& columns, const ControlSummary& control) {
  const PassivityReport& report = control.report;
  const auto known = [&](double value) { return report.on ? value : unknown; };
  columns.push_back({"passivity.control", ColumnValue(report.on), "",
                     "true: session.passivity = \"control\"; the rest of passivity is empty without it"});
  Group(columns, "passivity")
      .number("added_p50", control.added_p50, "1",
              "force error that the control added: |sent - without| / max(|without|, session.error_floor)")
      .number("added_p95", control.added_p95, "1", "of that, the 95th percentile")
      .number("added_max", control.added_max, "1", "of that, the largest")
      .number("coupling", known(report.coupling), "N/m",
              "largest stiffness rendered; empty: no limit is known")
      .number("coupled_share", control.coupled_share, "1", "frames in which the body was stiffer than that")
      .number("drained_share", control.drained_share, "1", "frames in which the tank held force back")
      .number("damped_share", control.controlled_share, "1", "frames in which the controller damped")
      .number("least_gain", known(report.least_gain), "1", "least share of the force that was rendered")
      .number("refused_J", known(report.refused), "J", "energy that switches would have generated")
      .number("damped_J", known(report.dissipated), "J", "energy taken by the controller")
      .number("lowest_J", known(report.lowest), "J",
              "least energy in the tank; below zero: it could not be held");
}

void add_felt_steps(std::vector<Column>& columns, const FeltSteps& felt) {
  constexpr std::array<std::string_view, all_felt_causes.size()> meanings = {
      "steps by a change of models",
      "by a site that slid",
      "by a site that snaps, in several frames",
      "by the begin of a touch, or the start-up ramp",
      "by the end of a touch, or of the session, where the force shrinks at the slew limit",
      "by the motion itself or another safety rule"};
  Group group(columns, "felt_steps");
  group
      .count("count", felt.count,
             "steps of the force sent that a hand feels: runs of windows of 10 ms in which it changes, "
             "beyond what the model gives for the tip's way, by more than the just noticeable difference (7 "
             "% of "
             "the larger of the forces at its ends, 10 mN)")
      .number("largest_N", felt.largest, "N", "largest of these changes")
      .number("largest_share", felt.largest_share, "1", "largest of them over the force");
  for (const FeltCause cause : all_felt_causes) {
    const auto i = static_cast<std::size_t>(cause);
    group.count("by_cause." + std::string(name(cause)), felt.by_cause[i], meanings[i]);
  }
}

void add_touches(std::vector<Column>& columns, const std::optional<TouchNumbers>& touch) {
  const TouchNumbers t = touch.value_or(TouchNumbers());
  const auto known = [&](auto value) { return touch ? static_cast<double>(value) : unknown; };
  Group(columns, "touch")
      .number("count", known(t.count), "", "touches that began; touch.* is known for contact.anywhere only")
      .number("time", t.time, "1", "share of the frames in touch")
      .number("slipping", t.slipping, "1", "share of these in which the site slid")
      .number("slid", known(t.slid), "m", "way of the site over the surface")
      .number("lost_J", known(t.lost), "J", "energy lost by sliding, and where touches ended under force")
      .number("stored_J", known(t.stored), "J", "largest energy stored by body and pad")
      .number(
          "cone", t.cone, "1",
          "largest relative distance of |g| / (f . n) from the coefficient of friction while sliding on a "
          "facet; kept edges, the clamp's border and frames out of the cone left out")
      .number("out_of_cone", t.out_of_cone, "1",
              "share of the time in touch in which the site is out of the cone: behind the tip and catching "
              "up, where the body snaps or the tip is too fast")
      .number("out_of_cone_longest", t.out_of_cone_longest, "s", "longest such time on end")
      .number("angle_p50", t.angle_p50, "rad", "median angle of the force to the normal")
      .number("angle_p95", t.angle_p95, "rad", "95th percentile of it")
      .number("jets", known(t.jets), "",
              "jets at rest that were made at the hand's place; not in states.solved")
      .number(
          "beyond", t.beyond, "1",
          "share of the time in touch in which the tip is farther from its site than any state is placed");
}

}  // namespace

ColumnValue column_value(double value) {
  return std::isfinite(value) ? ColumnValue(value) : ColumnValue();
}

std::vector<Column> later_columns(const SessionSummary& summary) {
  std::vector<Column> columns;
  Group(columns, "states")
      .count("inverted", summary.states.inverted, "solved states with inverted elements; not in solved");
  Group(columns, "safety")
      .number("clamped_share", summary.safety.clamped_share, "1", "clamped, as a share of the frames")
      .number("slewed_share", summary.safety.slewed_share, "1", "slewed, as a share of the frames");
  Group(columns, "")
      .number("time_outside", summary.motion.outside, "1",
              "share of the frames with the tip outside the box of states");
  Group(columns, "start")
      .number("reference", summary.motion.start_reference, "N", "|force| of a tight solve at the first frame")
      .number("rendered", summary.motion.start_rendered, "N", "|force| rendered in the first frame")
      .number("within_jnd_at", summary.motion.start_within_jnd, "s",
              "time of the first sample within the just noticeable difference");
  const SessionSummary::AwayFromStates& away = summary.motion.away;
  Group(columns, "away_from_states")
      .number("p50", away.median, "m",
              "median distance of the tip from the nearest state; of states of another body")
      .number("max", away.farthest, "m", "largest distance")
      .number("error_bar", away.bar, "N", "median 95 % error bar of the force that the states tell there")
      .number("error_bar_at_states", away.bar_at_states, "N", "that at the states themselves")
      .label("worst_label", std::isnan(away.worst_share) ? std::nullopt : std::optional(away.worst),
             "label under which the states tell the force worst")
      .number("worst_share", away.worst_share, "1", "share of the frames with that label")
      .number("worst_error_bar", away.worst_bar, "N",
              "95th percentile of the 95 % error bars in these frames")
      .number("rest_error_bar", away.rest_bar, "N", "median 95 % error bar of all other frames");
  add_stability(columns, summary);
  add_error_bars(columns, summary.error.bars);
  add_trust(columns, summary.error);
  add_control(columns, summary.energy.control);
  const SessionSummary::Mesh& mesh = summary.error.mesh;
  Group(columns, "")
      .number("discretisation_error", mesh.error, "1",
              "what the mesh itself gets wrong of the force, largest over the positions; not in error")
      .number("discretisation_low", mesh.low, "1", "lower end of an interval that holds it")
      .number("discretisation_high", mesh.high, "1", "upper end; empty where only a lower bound is known")
      .count("discretisation_positions", mesh.positions, "positions at which that was measured")
      .text("discretisation_by", mesh.how, "finer body that it was measured with, or why it was not");
  add_faults(columns, summary.loop.faults);
  add_touches(columns, summary.motion.touch);
  add_felt_steps(columns, summary.safety.felt);
  return columns;
}

std::vector<Column> summary_columns(const SessionSummary& summary) {
  const auto& [settings, run, deadline, states, time_in, switching, error, load, energy, safety, loop,
               motion] = summary;
  std::vector<Column> columns;
  Group(columns, "")
      .text("clock", settings.clock == Clock::real ? "real" : "virtual", "real or virtual")
      .number("seconds", run.seconds, "s", "length of the motion")
      .count("frames", run.frames, "frames rendered");
  add_deadline(columns, deadline);
  add_states(columns, states);
  add_time_in(columns, time_in);
  add_switching(columns, switching);
  add_error(columns, error, states.foreign);
  Group(columns, "")
      .number("load", load, "1", "states needed per second of motion / states solved per second");
  Group(columns, "energy")
      .number("generated_J", energy.generated, "J", "largest energy that the hand got back beyond its work")
      .number("work_J", energy.work, "J", "sum of |force sent . step of the tip|");
  add_safety(columns, safety);
  add_loop(columns, loop);
  add_settings(columns, settings, run);
  for (Column& column : later_columns(summary)) columns.push_back(std::move(column));
  return columns;
}

std::vector<Declared> declared_columns(const std::vector<Column>& columns) {
  std::vector<Declared> rows;
  for (const Column& column : columns) {
    std::string shown = column.name;
    bool repeated = false;  // of a label after the first
    for (const Label label : all_labels) {
      const std::string word = "." + std::string(name(label));
      const std::size_t at = shown.find(word), end = at + word.size();
      if (at == std::string::npos || (end < shown.size() && shown[end] != '.')) continue;
      shown.replace(at, word.size(), ".LABEL");
      repeated = label != all_labels.front();
    }
    if (!repeated) rows.push_back({shown, std::string(column.unit), "", std::string(column.meaning)});
  }
  return rows;
}

}  // namespace forefeel
