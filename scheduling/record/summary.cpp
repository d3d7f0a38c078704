#include "scheduling/record/summary.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "geometry/common/quantiles.hpp"
#include "geometry/states/state_outcome.hpp"
#include "scheduling/motion/hand_device.hpp"
#include "scheduling/record/felt_steps.hpp"
#include "scheduling/record/needed_states.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/session/session_input.hpp"
#include "scheduling/session/session_plan.hpp"

namespace forefeel {
namespace {

double rank_quantile(const std::vector<double>& sorted, double share) {
  return quantile(sorted, share, QuantileRule::inverted_cdf);
}

SessionSummary::Timing timing(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  std::sort(values.begin(), values.end());
  return {
      .p50 = rank_quantile(values, 0.5), .p99 = rank_quantile(values, 0.99), .max = rank_quantile(values, 1)};
}

double jnd(const Vec3& force, const SwitchOptions& options) {
  return std::max(options.jnd_share * force.norm(), options.jnd_floor);
}

template <class Choose>
SessionSummary::Errors errors_of(const SessionResult& result, const SwitchOptions& options, Choose choose) {
  std::vector<double> sorted;
  std::size_t within = 0;
  for (const FrameRecord& f : result.frames) {
    if (!std::isfinite(f.judged.error) || !choose(f)) continue;
    sorted.push_back(f.judged.error);
    within += (compared_force(f) - f.judged.reference).norm() <= jnd(f.judged.reference, options);
  }
  std::sort(sorted.begin(), sorted.end());
  return {.samples = sorted.size(),
          .p50 = rank_quantile(sorted, 0.5),
          .p95 = rank_quantile(sorted, 0.95),
          .max = rank_quantile(sorted, 1),
          .within_jnd =
              sorted.empty() ? unknown : static_cast<double>(within) / static_cast<double>(sorted.size())};
}

// The finite values of one part of the error at the samples, sorted.
std::vector<double> sorted_part(const SessionResult& result, double Judgement::*part) {
  std::vector<double> sorted;
  for (const FrameRecord& f : result.frames)
    if (f.judged.sampled && std::isfinite(f.judged.*part)) sorted.push_back(f.judged.*part);
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

bool has_judged_bar(const FrameRecord& f) {
  return f.judged.sampled && std::isfinite(f.judged.error) && std::isfinite(f.bar.half_width[1]);
}

// Bars refer to the elastic force.
bool viscous(const FrameRecord& f) {
  return std::isfinite(f.judged.elastic_reference.x());
}

double elastic_error(const FrameRecord& f) {
  return viscous(f) ? (f.elastic - f.judged.elastic_reference).norm() : (f.force - f.judged.reference).norm();
}

// Samples at the floor of the bars, and how many of those above it are inside.
void count_floor(const SessionResult& result, const SwitchOptions& options, SessionSummary::ErrorBars& bars) {
  for (std::size_t level = 0; level < bars.at_floor.size(); ++level) {
    std::size_t above = 0, inside = 0;
    for (const FrameRecord& f : result.frames) {
      if (!has_judged_bar(f)) continue;
      const double floor = bar_floor(viscous(f) ? f.elastic : f.force, options);
      const bool floored = f.bar.half_width[level] <= floor * (1 + 1e-9);
      bars.at_floor[level] += floored ? 1 : 0;
      above += floored ? 0 : 1;
      inside += !floored && elastic_error(f) <= f.bar.half_width[level] ? 1 : 0;
    }
    if (above > 0) bars.inside_above[level] = static_cast<double>(inside) / static_cast<double>(above);
  }
}

template <class Choose>
SessionSummary::Bars bars_of(const SessionResult& result, Choose choose) {
  SessionSummary::Bars bars;
  std::array<std::size_t, 3> inside{};
  std::vector<double> widths, errors;
  for (const FrameRecord& f : result.frames) {
    if (!has_judged_bar(f) || !choose(f)) continue;
    const double error = elastic_error(f);
    for (std::size_t i = 0; i < inside.size(); ++i) inside[i] += error <= f.bar.half_width[i];
    widths.push_back(f.bar.half_width[1]);
    errors.push_back(error);
  }
  bars.samples = errors.size();
  if (errors.empty()) return bars;
  for (std::size_t i = 0; i < inside.size(); ++i)
    bars.inside[i] = static_cast<double>(inside[i]) / static_cast<double>(errors.size());
  std::sort(widths.begin(), widths.end());
  std::sort(errors.begin(), errors.end());
  bars.width_p50 = rank_quantile(widths, 0.5);
  bars.error_p95 = rank_quantile(errors, 0.95);
  if (bars.error_p95 > 0) bars.width_over_p95 = bars.width_p50 / bars.error_p95;
  return bars;
}

SessionSummary::ErrorBars error_bars_of(const SessionResult& result, const SwitchOptions& options) {
  SessionSummary::ErrorBars found;
  count_floor(result, options, found);
  found.all = bars_of(result, [](const FrameRecord&) { return true; });
  for (const Label label : all_labels)
    found.by_label[label] = bars_of(result, [label](const FrameRecord& f) { return f.label == label; });
  const auto judged = std::ranges::count_if(
      result.frames, [](const FrameRecord& f) { return f.judged.sampled && std::isfinite(f.judged.error); });
  found.without = static_cast<std::size_t>(judged) - found.all.samples;
  return found;
}

// Of all frames; of a body that may be touched anywhere, of those in touch.
bool counts(const FrameRecord& frame, bool anywhere) {
  return !anywhere || frame.touch.kind != TouchKind::none;
}

double share_of(std::size_t part, std::size_t whole) {
  return static_cast<double>(part) / static_cast<double>(std::max<std::size_t>(1, whole));
}

SessionSummary::Error error_of(const SessionResult& result, const SwitchOptions& options, bool jets,
                               bool anywhere) {
  SessionSummary::Error error;
  error.samples = errors_of(result, options, [](const FrameRecord& f) { return f.judged.sampled; });
  const std::vector<double> approximation = sorted_part(result, &Judgement::approximation),
                            switching = sorted_part(result, &Judgement::switching),
                            staleness = sorted_part(result, &Judgement::staleness);
  error.parts_p95 = {rank_quantile(approximation, 0.95), rank_quantile(switching, 0.95),
                     rank_quantile(staleness, 0.95)};
  error.parts_p50 = {rank_quantile(approximation, 0.5), rank_quantile(switching, 0.5),
                     rank_quantile(staleness, 0.5)};
  for (const Label label : all_labels)
    error.by_label[label] = errors_of(
        result, options, [label](const FrameRecord& f) { return f.judged.sampled && f.label == label; });
  for (const bool trusted : {false, true})
    error.by_trust[trusted ? 1 : 0] = errors_of(result, options, [trusted](const FrameRecord& f) {
      return f.judged.sampled && f.bar.trusted == trusted;
    });
  const auto trusted =
      std::ranges::count_if(result.frames, [](const FrameRecord& f) { return f.bar.trusted; });
  const auto counted =
      std::ranges::count_if(result.frames, [=](const FrameRecord& f) { return counts(f, anywhere); });
  if (jets || anywhere)
    error.time_trusted = share_of(static_cast<std::size_t>(trusted), static_cast<std::size_t>(counted));
  error.bars = error_bars_of(result, options);
  error.first_visit = errors_of(result, options, [](const FrameRecord& f) { return f.judged.first_visit; });
  return error;
}

SessionSummary::Deadline deadline_of(const SessionResult& result, const SessionOptions& options) {
  std::size_t missed = 0;
  std::vector<double> cost, lateness;
  for (const FrameRecord& f : result.frames) {
    cost.push_back(f.timing.cost_us);
    lateness.push_back(f.timing.lateness_us);
    missed += f.timing.cost_us + f.timing.lateness_us > options.clock.frame * 1e6;
  }
  return {.missed = missed + result.loop.skipped,
          .cost_us = timing(std::move(cost)),
          .lateness_us = timing(std::move(lateness))};
}

SessionSummary::States states_of(const SessionResult& result, bool foreign) {
  std::size_t used = 0;
  std::vector<double> age;
  for (const DispatchRecord& d : result.dispatch) {
    if (is_jet_at_rest(d)) continue;
    if ((d.status != DispatchStatus::solved && d.status != DispatchStatus::arrived) ||
        !std::isfinite(d.first_used))
      continue;
    ++used;
    age.push_back(1e3 * (d.first_used - d.finished));
  }
  std::sort(age.begin(), age.end());
  const auto& [start, all_solved, failed, preempted, set_aside] = result.counts;
  const std::size_t solved = all_solved - std::min(all_solved, jets_at_rest(result));
  // Those known at the start come first.
  const std::span<const State> fresh =
      std::span(result.states).subspan(std::min(start, result.states.size()));
  const auto inverted = static_cast<std::size_t>(std::ranges::count_if(fresh, has_inverted_elements));
  return {.start = start,
          .solved = solved - std::min(inverted, solved),
          .used = used,
          .wasted = solved - std::min(used, solved),
          .preempted = preempted,
          .failed = failed,
          .inverted = inverted,
          .age_at_use_ms_p50 = rank_quantile(age, 0.5),
          .age_at_use_ms_p99 = rank_quantile(age, 0.99),
          .foreign = foreign};
}

// Largest |sum of dF| within any window of given length [s].
double drift(const SessionResult& result, double window, double frame) {
  std::vector<Vec3> sum(result.frames.size() + 1, Vec3::Zero());
  for (std::size_t k = 0; k < result.frames.size(); ++k) sum[k + 1] = sum[k] + result.frames[k].step.delta;
  if (result.frames.size() < 2) return 0;
  const auto width =
      std::min(result.frames.size(), static_cast<std::size_t>(std::max(1LL, std::llround(window / frame))));
  double most = 0;
  for (std::size_t k = 0; k + width < sum.size(); ++k)
    most = std::max(most, (sum[k + width] - sum[k]).norm());
  return most;
}

SessionSummary::Switching switching_of(const SessionResult& result, SwitchRule rule, double frame) {
  SessionSummary::Switching found{.count = result.switches.size(), .rule = rule};
  for (const FrameRecord& f : result.frames) {
    found.max_jump = std::max(found.max_jump, f.step.change);
    found.max_jump_undamped = std::max(found.max_jump_undamped, f.step.undamped_jump);
    found.frames_over_jnd += f.step.change > f.step.bound;
  }
  found.drift_50ms = drift(result, 0.05, frame);
  found.drift_100ms = drift(result, 0.1, frame);
  found.drift_300ms = drift(result, 0.3, frame);
  return found;
}

// States needed per second of motion, without those known at the start, divided by the states that busy
// workers solve per second. A job takes the time of its solves and two messages.
double load_of(const SessionResult& result, const SessionInput& input, const SessionOptions& options) {
  if (input.touched.anywhere) return unknown;  // of sites there is no lattice
  const double h = visit_cell(options.judging, input.touched.space.spacing);
  NeededStates needed(input.touched.space.box, h);
  for (std::size_t i = 0; i < result.counts.start; ++i) needed.know(result.states[i].at);
  for (const FrameRecord& f : result.frames) needed.visit(f.at);
  if (result.frames.empty() || result.solver.seconds.empty() || result.solver.workers == 0) return unknown;
  const double seconds =
      result.frames.back().t + (result.frames.size() > 1 ? frame_time(1, options.clock.frame) : 0);
  const double messages = options.clock.kind == Clock::virtual_time
                              ? 2 * options.workers.latency * static_cast<double>(result.solver.jobs)
                              : 0;
  const double total = std::accumulate(result.solver.seconds.begin(), result.solver.seconds.end(), messages);
  const double rate = result.solver.workers * static_cast<double>(result.solver.seconds.size()) / total;
  return static_cast<double>(needed.count()) / seconds / rate;
}

ByLabel<double> time_in_labels(const SessionResult& result, bool anywhere) {
  ByLabel<std::size_t> frames;
  std::size_t all = 0;
  for (const FrameRecord& f : result.frames)
    if (counts(f, anywhere)) ++frames[f.label], ++all;
  ByLabel<double> shares;
  for (const Label label : all_labels) shares[label] = share_of(frames[label], all);
  return shares;
}

// A part given as an object is named after the object, because it ran instead of the part named in the options.
std::string policy_that_ran(const SessionInput& input, const SessionOptions& options) {
  return input.parts.policy ? std::string(input.parts.policy->name()) : to_text(options.planning.policy);
}
std::string device_that_ran(const SessionInput& input, const SessionOptions& options) {
  if (options.motion.replay) return "replay:" + options.motion.replay->string();
  return input.parts.device ? "object" : to_text(options.motion.device);
}
SessionSummary::Settings settings_of(const SessionInput& input, const SessionOptions& options) {
  return {.clock = options.clock.kind,
          .workers = options.workers.count,
          .policy = policy_that_ran(input, options),
          .select = options.model.fit.select,
          .seed = options.seed,
          .spacing = input.touched.space.spacing,
          .cost = options.clock.kind == Clock::real ? "" : to_text(options.workers.cost),
          .device = device_that_ran(input, options)};
}

SessionSummary::Run run_of(const SessionResult& result, const SessionOptions& options) {
  // In frames. Rounding may leave the last one out of a run that went to its end.
  const double passed =
      result.frames.empty() ? 0 : std::round(result.frames.back().t / options.clock.frame) + 1;
  const bool whole = passed > options.clock.seconds / options.clock.frame - 0.75;
  return {.seconds = whole ? options.clock.seconds : passed * options.clock.frame,
          .frames = result.frames.size(),
          .frames_asked = static_cast<std::size_t>(std::llround(options.clock.seconds / options.clock.frame)),
          .interrupted = result.interrupted(),
          .first_guess = !result.switches.empty() && result.switches.front().cause == SwitchCause::guess,
          .guess_softness = result.run.guess_softness,
          .wall_seconds = result.run.wall_seconds,
          .realtime_priority = result.run.realtime_priority,
          .memory_locked = result.run.memory_locked,
          .notes = result.notes,
          .failures = result.failures};
}

SessionSummary::Energy energy_of(const SessionResult& result, const SessionInput& input,
                                 const SessionOptions& options) {
  SessionSummary::Energy energy{.generated = result.safety.generated, .work = result.safety.work};
  energy.control = control_summary(result, options.judging.error_floor);
  if (options.motion.replay) return energy;
  const auto* hand = input.parts.device ? nullptr : std::get_if<HandMotion>(&options.motion.device.motion());
  if (hand) energy.hand = hand_numbers(drawn_hand(*hand, options.seed));
  if (hand || (input.parts.device && input.parts.device->answers_force()))
    energy.stability = judge_stability(result.frames, energy.hand, options.clock.frame);
  return energy;
}

SessionSummary::Faults faults_of(const SessionResult& result) {
  return {.states_set_aside = result.counts.set_aside,
          .workers_lost = static_cast<std::size_t>(result.solver.lost),
          .planner_stalls = result.loop.planner_stalls,
          .clock_steps = result.loop.clock_steps,
          .device_held = result.loop.device_held,
          .device_jumps = result.loop.device_jumps};
}

SessionSummary::Loop loop_of(const SessionResult& result, const SessionOptions& options) {
  const LoopReport& loop = result.loop;
  const bool real = options.clock.kind == Clock::real;
  return {.skipped = loop.skipped,
          .longest_pause = real ? loop.longest_pause : unknown,
          .planner_stall = real ? loop.planner_stall : unknown,
          .ending_frames = loop.ending_frames,
          .last_force = loop.last_force,
          .faults = faults_of(result)};
}

SessionSummary::Safety safety_of(const SessionResult& result, const SessionOptions& options) {
  const SafetyReport& report = result.safety;
  return {.clamped = report.clamped,
          .slewed = report.slewed,
          .stale = report.stale,
          .non_finite = report.non_finite,
          .clamped_share = share_of(report.clamped, result.frames.size()),
          .slewed_share = share_of(report.slewed, result.frames.size()),
          .felt = felt_steps_of(result, felt_rule(options.switching, options.safety))};
}

SessionSummary::Motion motion_of(const SessionResult& result, const StateSpaceOptions& space,
                                 const SessionOptions& options) {
  if (result.frames.empty()) return {};
  const Vec3 slack = Vec3::Constant(1e-6 * space.spacing);  // a path may touch a face
  const Box box{space.box.low - slack, space.box.high + slack};
  const auto outside =
      std::ranges::count_if(result.frames, [&](const FrameRecord& f) { return !box.contains(f.at); });
  SessionSummary::Motion motion{.outside =
                                    static_cast<double>(outside) / static_cast<double>(result.frames.size())};
  const FrameRecord& first = result.frames.front();
  const auto within = [&](const FrameRecord& f) {
    return (compared_force(f) - f.judged.reference).norm() <= jnd(f.judged.reference, options.switching);
  };
  motion.start_rendered = first.force.norm();
  if (!first.judged.reference.allFinite()) return motion;
  motion.start_reference = first.judged.reference.norm();
  motion.starts_wrong = !within(first) && motion.start_reference > options.judging.error_floor;
  const auto settled = std::ranges::find_if(result.frames, [&](const FrameRecord& f) {
    return f.judged.sampled && f.judged.reference.allFinite() && within(f);
  });
  if (settled != result.frames.end()) motion.start_within_jnd = settled->t;
  return motion;
}

}  // namespace

SessionSummary summarise(const SessionResult& result, const SessionInput& input,
                         const SessionOptions& options) {
  SessionSummary summary{.settings = settings_of(input, options),
                         .run = run_of(result, options),
                         .deadline = deadline_of(result, options),
                         .states = states_of(result, input.foreign),
                         .time_in = time_in_labels(result, input.touched.anywhere != nullptr),
                         .switching = switching_of(result, options.switching.rule, options.clock.frame),
                         .error = error_of(result, options.switching, options.model.fit.data == Data::jet,
                                           input.touched.anywhere != nullptr),
                         .load = load_of(result, input, options),
                         .energy = energy_of(result, input, options),
                         .safety = safety_of(result, options),
                         .loop = loop_of(result, options),
                         .motion = motion_of(result, input.touched.space, options)};
  if (!input.touched.anywhere) return summary;
  summary.motion.touch = touches_of(result, *input.touched.anywhere);
  summary.motion.outside = unknown;  // there is no box: the hand moves beside the body
  return summary;
}

SessionSummary summarise(const SessionResult& result, const SessionPlan& plan) {
  SessionSummary summary = summarise(result, plan.input, plan.options);
  summary.run.frames_asked = plan.frames;
  summary.safety.force_limit = plan.render.safety.force_limit;
  std::optional<StabilityReport>& stability = summary.energy.stability;
  if (!stability && plan.device->answers_force())  // of a registered device
    stability = judge_stability(result.frames, summary.energy.hand, plan.options.clock.frame);
  return summary;
}

}  // namespace forefeel
