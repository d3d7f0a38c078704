#include "scheduling/record/attention.hpp"
#include "geometry/common/counted.hpp"

#include <fmt/format.h>

#include <cmath>
#include <tuple>

namespace forefeel {
namespace {

constexpr double coupled_often = 0.01;  // share of the frames

std::string starts_pressed_in(const SessionSummary::Motion& motion) {
  const std::string end =
      std::isfinite(motion.start_within_jnd)
          ? fmt::format("the first sample within the JND came after {:.2g} s", motion.start_within_jnd)
          : std::string("no later sample was within the JND");
  return fmt::format(
      "the motion starts pressed in: the body's force is {:.3g} N there, {:.3g} N was rendered, and {}",
      motion.start_reference, motion.start_rendered, end);
}

// The worst part of the time first: a median says nothing of it.
std::string far_from_states(const SessionSummary::AwayFromStates& away) {
  const std::string way = fmt::format("{:.2g} mm (median; {:.2g} mm at most) from the nearest known place",
                                      1e3 * away.median, 1e3 * away.farthest);
  if (std::isnan(away.worst_share)) return "the hand was " + way + "; too few states for an error bar";
  std::string line = fmt::format("the hand was in {} for {} of the time, where the states tell ",
                                 name(away.worst), in_percent(away.worst_share));
  line += std::isfinite(away.worst_bar)
              ? fmt::format("the force within {:.2g} N (p95 of the error bars of 95 %)", away.worst_bar)
              : std::string("no bound of the force");
  if (std::isfinite(away.worst_bar) && std::isfinite(away.rest_bar))
    line += fmt::format(", against {:.2g} N in the rest of it (median)", away.rest_bar);
  return line + "; it was " + way;
}

std::string clamped(const SessionSummary::Safety& safety) {
  const std::string limit =
      std::isfinite(safety.force_limit) ? fmt::format(" of {:.3g} N", safety.force_limit) : std::string();
  return fmt::format(
      "{:.3g} % of the frames were clamped at the force limit{}: the device got less than was rendered",
      100 * safety.clamped_share, limit);
}

std::string unstable(const StabilityReport& report, const SessionSummary::Safety& safety) {
  std::string line = fmt::format("ran, but unstable at {:.3g} s", report.since);
  if (report.generated > 0)
    line += fmt::format("; the loop generated {:.3g} J within a second", report.generated);
  if (report.hold > held_too_much)
    line += fmt::format("; the hand got {:.3g} J in all because each force is held for a frame", report.hold);
  if (std::isfinite(report.frequency))
    line += fmt::format("; the hand shakes at {:.3g} Hz, {:.2g} mm RMS", report.frequency,
                        1e3 * report.amplitude);
  if (safety.clamped_share > clamped_too_often)
    line += fmt::format("; {:.3g} % of the frames were clamped", 100 * safety.clamped_share);
  return line;
}

std::string held_by(const TouchNumbers& touch) {
  switch (touch.holder) {
    case SiteHolder::edge:
      return "an edge of the body holds the site; lift the tip to touch the face beyond it";
    case SiteHolder::clamp:
      return "the border of the clamp holds the site";
    case SiteHolder::lag:
      return "the body snaps under the tip, and the site is behind";
    case SiteHolder::minimum:
      return "the site is where its energy is least; raise state_space.depth";
    default:
      return fmt::format("contact.friction = {:g} holds the site; lower it, or raise state_space.depth",
                         touch.friction);
  }
}

// A site that does not follow the tip.
std::string dragged(const TouchNumbers& touch) {
  const std::string share = fmt::format(
      "the tip was farther from its site than any state is placed for {:.2g} % of the time in touch, and the "
      "force "
      "there is extrapolated: ",
      100 * touch.beyond);
  if (!std::isfinite(touch.friction))
    return share + "contact.bonded = true holds the site; without it the site slides after the tip";
  return share + held_by(touch);
}

// A label whose 95 % bars held far less often than they say, with enough samples to tell.
void add_short_bars(const SessionSummary::ErrorBars& bars, std::vector<std::string>& lines) {
  constexpr double least = 0.85;
  constexpr std::size_t enough = 50;
  for (const Label label : all_labels) {
    const SessionSummary::Bars& b = bars.by_label[label];
    if (b.samples >= enough && b.inside[1] < least)
      lines.push_back(fmt::format("the 95 % error bar held in only {:.3g} % of {} labelled {}",
                                  100 * b.inside[1], counted(b.samples, "sample"), name(label)));
  }
}

std::string coarse(const SessionSummary::Mesh& mesh) {
  return fmt::format(
      "the mesh itself errs by {} of the force, a hand feels {}: more or quadratic elements help",
      in_percent(mesh.error), in_percent(felt_share));
}

std::string outside_box(const SessionSummary::Motion& motion) {
  return fmt::format("{} of the time was outside the box of states: forces there are extrapolated",
                     said_percent(motion.outside));
}

// What went wrong around the loop, which ran on.
void add_faults(const SessionSummary::Loop& loop, std::vector<std::string>& lines) {
  const SessionSummary::Faults& faults = loop.faults;
  const auto add = [&](std::size_t n, const char* one, const char* several, const std::string& rest) {
    if (n > 0) lines.push_back(counted(n, one, several) + rest);
  };
  add(faults.device_held, "frame", "frames",
      " without a finite position of the device: the last one was held");
  add(faults.device_jumps, "frame", "frames", " with a jump of the device: over 1 m/s, faster than any hand");
  add(faults.states_set_aside, "solved state was", "solved states were",
      " set aside: not a number, or far too strong for this body");
  add(faults.workers_lost, "worker was", "workers were", " lost: failed, or did not answer");
  add(faults.planner_stalls, "time", "times",
      fmt::format(" the planner stood still until the force faded out, for up to {:.3g} s",
                  loop.planner_stall));
  if (loop.longest_pause > long_pause)
    lines.push_back(fmt::format("the loop stood still for {:.3g} s, and {} skipped", loop.longest_pause,
                                counted(loop.skipped, "frame was", "frames were")));
  add(faults.clock_steps, "time", "times",
      " the clock of the day was set or the machine slept; times of the run are of a clock that is never "
      "set");
}

std::string controlled(const ControlSummary& control) {
  std::string line = fmt::format(
      "passivity control changed the force sent by {} (p50), {} (p95); the errors are those of "
      "the rendered force, before it",
      in_percent(control.added_p50), in_percent(control.added_p95));
  if (control.coupled_share > coupled_often)
    line += fmt::format(
        "; in {} of the frames the body is stiffer than {:.4g} N/m, the most that the loop of this "
        "device and "
        "hand can render without swinging",
        in_percent(control.coupled_share), control.report.coupling);
  return line;
}

std::string samples(const char* what, std::size_t n) {
  return fmt::format("{} rest on {}", what, counted(n, "sample"));
}

}  // namespace

std::vector<std::string> attention(const SessionSummary& summary) {
  const auto& [motion, safety, states] = std::tie(summary.motion, summary.safety, summary.states);
  std::vector<std::string> lines;
  if (motion.touch && motion.touch->beyond > outside_too_often) lines.push_back(dragged(*motion.touch));
  const std::optional<StabilityReport>& stability = summary.energy.stability;
  if (stability && !stability->stable) lines.push_back(unstable(*stability, safety));
  if (std::isfinite(motion.away.median)) lines.push_back(far_from_states(motion.away));
  const SessionSummary::Error& error = summary.error;
  if (error.mesh.is_felt(error.samples.p95)) lines.push_back(coarse(error.mesh));
  if (safety.clamped_share > clamped_too_often) lines.push_back(clamped(safety));
  if (summary.energy.control.added_p95 > added_too_much) lines.push_back(controlled(summary.energy.control));
  if (motion.starts_wrong) lines.push_back(starts_pressed_in(motion));
  if (outside_is_felt(summary)) lines.push_back(outside_box(motion));
  add_faults(summary.loop, lines);
  if (states.inverted > 0)
    lines.push_back(
        fmt::format("{} of {} inverted elements: no body takes that shape", states.inverted,
                    counted(states.solved + states.inverted, "solved state has", "solved states have")));
  // a touch stands on the jets at rest of the body itself
  if (summary.run.frames > 0 && !motion.touch && states.start + states.solved + states.used == 0)
    lines.push_back("no state was solved: what was rendered is no force of the body");
  add_short_bars(summary.error.bars, lines);
  const std::size_t sampled = summary.error.samples.samples;
  if (summary.run.frames > 0 && sampled < few_samples) lines.push_back(samples("the errors", sampled));
  return lines;
}

bool outside_is_felt(const SessionSummary& summary) {
  const SessionSummary::Errors& samples = summary.error.samples;
  if (!(summary.motion.outside > outside_too_often)) return false;
  return samples.samples < few_samples || !(1 - samples.within_jnd <= 0.1 * summary.motion.outside);
}

std::vector<std::string> remarks(const SessionSummary& summary) {
  std::vector<std::string> lines;
  const SessionSummary::Mesh& mesh = summary.error.mesh;
  if (!std::isfinite(mesh.error))
    lines.push_back("the error of the mesh itself is not known: " + mesh.how);
  else
    lines.push_back(fmt::format("the mesh itself errs by {}, a hand feels {} ({})", said_percent(mesh.error),
                                in_percent(felt_share), mesh.how));
  const std::size_t visits = summary.error.first_visit.samples;
  if (summary.run.frames > 0 && visits > 0 && visits < few_samples)
    lines.push_back(samples("the errors of first visits", visits) +
                    ": a motion that goes to more places tells more");
  const double outside = summary.motion.outside;
  if (outside > outside_too_often && !outside_is_felt(summary))
    lines.push_back(outside_box(summary.motion) + ", without an error that a hand feels");
  return lines;
}

std::string share_of_samples(double share, std::size_t samples) {
  if (samples == 0 || !std::isfinite(share)) return "unknown";
  const auto n = static_cast<double>(samples);
  if (samples < few_samples) return fmt::format("{:.0f} of {}", std::round(share * n), samples);
  return fmt::format("{} of {}", said_percent(share), samples);
}

}  // namespace forefeel
