#include "apps/session/touch_summary.hpp"

#include <algorithm>
#include <cmath>

#include "apps/console/outputs.hpp"
#include "geometry/common/quantiles.hpp"
#include "scheduling/touch/touch_files.hpp"
#include "scheduling/touch/touch_judge.hpp"

namespace forefeel {
namespace {

using Frame = TouchFrameRecord;

template <class Wanted>
TouchErrors errors_of(const std::vector<Frame>& frames, const SwitchOptions& jnd, Wanted wanted) {
  TouchErrors errors;
  std::vector<double> values;
  std::size_t within = 0;
  for (const Frame& frame : frames) {
    if (!std::isfinite(frame.judged.error) || !wanted(frame)) continue;
    values.push_back(frame.judged.error);
    within += is_within_jnd(frame, jnd);
  }
  errors.samples = values.size();
  if (values.empty()) return errors;
  errors.within_jnd = static_cast<double>(within) / static_cast<double>(values.size());
  std::ranges::sort(values);
  errors.p50 = quantile(values, 0.5, QuantileRule::nearest);
  errors.p95 = quantile(values, 0.95, QuantileRule::nearest);
  errors.max = values.back();
  return errors;
}

TouchBars bars_of(const std::vector<Frame>& frames, const SwitchOptions& jnd, std::size_t level) {
  TouchBars bars;
  std::vector<double> widths;
  std::size_t inside = 0, inside_above = 0;
  for (const Frame& frame : frames) {
    const double width = frame.source.bar.half_width[level];
    if (!frame.judged.sampled || !frame.judged.reference.allFinite() || !std::isfinite(width)) continue;
    const bool holds = (frame.force.elastic - frame.judged.reference).norm() <= width,
               floored = width <= touch_bar_floor(frame, jnd) * (1 + 1e-12);
    widths.push_back(width);
    inside += holds, inside_above += holds && !floored, bars.at_floor += floored;
  }
  if (widths.empty()) return bars;
  const std::size_t above = widths.size() - bars.at_floor;
  bars.inside = static_cast<double>(inside) / static_cast<double>(widths.size());
  if (above > 0) bars.inside_above = static_cast<double>(inside_above) / static_cast<double>(above);
  bars.width = quantile_of(widths, 0.5);
  return bars;
}

std::vector<double> two_quantiles(const std::vector<double>& values, double high) {
  if (values.empty()) return {};
  return {quantile_of(values, 0.5), quantile_of(values, high)};
}

void summarise_frames(const std::vector<Frame>& frames, const FieldPatches& patches, double friction,
                      TouchSummary& s) {
  std::vector<double> angles, costs;
  std::size_t touching = 0, slipping = 0, trusted = 0;
  ByLabel<std::size_t> labels{};
  const Frame* before = nullptr;
  for (const Frame& frame : frames) {
    s.touch.lost += frame.lost;
    s.switching.count += frame.step.took_model;
    s.switching.over_bound += frame.step.change > frame.step.bound * (1 + 1e-6);
    s.switching.max_jump = std::max(s.switching.max_jump, frame.step.undamped_jump);
    if (std::isfinite(frame.timing.cost_us)) costs.push_back(frame.timing.cost_us);
    const bool touches = frame.touch != TouchKind::none, touched = before && before->touch != TouchKind::none;
    if (touches) {
      ++touching, ++labels[frame.label], trusted += frame.source.bar.trusted;
      s.touch.count += !touched;
      s.touch.stored = std::max(s.touch.stored, frame.energy);
      const double push = frame.force.undamped.dot(frame.normal), size = frame.force.undamped.norm();
      if (size > 1e-3) angles.push_back(std::acos(std::clamp(push / size, -1.0, 1.0)));
    }
    if (frame.touch == TouchKind::slip) {
      ++slipping;
      if (touched) s.touch.slid += (frame.site.at - before->site.at).norm();
      if (friction > 0 && std::isfinite(frame.source.slope) && !frame.source.at_border &&
          !patches.is_on_edge(frame.site)) {
        const double off = std::abs(frame.source.slope - friction) / friction;
        s.touch.cone = std::isfinite(s.touch.cone) ? std::max(s.touch.cone, off) : off;
      }
    }
    before = &frame;
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : unknown;
  };
  s.touch.time = share(touching, frames.size()), s.touch.slipping = share(slipping, touching);
  for (const Label label : all_labels) s.time_in[label] = share(labels[label], touching);
  s.time_trusted = share(trusted, touching);
  s.touch.angle = two_quantiles(angles, 0.95);
  s.cost_us = two_quantiles(costs, 0.99);
}

}  // namespace

TouchSummary summarise_touch(const TouchSessionResult& result, const TouchSessionInput& input,
                             const SessionOptions& options) {
  TouchSummary s;
  s.settings = {.device = to_text(options.motion.device),
                .clock = options.clock.kind == Clock::real ? "real" : "virtual",
                .policy = to_text(options.planning.policy),
                .predictor = to_text(options.motion.predictor),
                .workers = options.workers.count,
                .seconds = options.clock.frame * static_cast<double>(result.frames.size()),
                .depth = input.task.depth,
                .site_spacing = input.site_spacing,
                .friction = input.task.friction};
  s.field.sites = input.task.field->size();
  s.frames = result.frames.size(), s.skipped = result.loop.skipped;
  s.interrupted = result.interrupted, s.notes = result.notes;
  s.references_failed = result.references_failed;
  s.states.start = result.known_at_start, s.states.failed = result.failed;
  for (const TouchDispatch& d : result.dispatches) {
    const bool solved = d.status == DispatchStatus::solved;
    s.states.jets += solved && d.x.isZero(0), s.states.solved += solved && !d.x.isZero(0);
    s.states.preempted += d.status == DispatchStatus::preempted;
  }
  summarise_frames(result.frames, *input.task.patches, input.task.friction.value_or(0), s);
  const auto errors = [&](auto wanted) { return errors_of(result.frames, options.switching, wanted); };
  s.samples = errors([](const Frame& f) { return f.judged.sampled; });
  s.first_visit = errors([](const Frame& f) { return f.judged.first_visit; });
  s.trusted = errors([](const Frame& f) { return f.judged.sampled && f.source.bar.trusted; });
  s.untrusted = errors([](const Frame& f) { return f.judged.sampled && !f.source.bar.trusted; });
  for (std::size_t level = 0; level < s.bars.size(); ++level)
    s.bars[level] = bars_of(result.frames, options.switching, level);
  s.safety = result.safety;
  std::vector<Vec3> sent;
  for (std::size_t k = 0; k + result.loop.ending_frames < result.frames.size(); ++k)
    sent.push_back(result.frames[k].force.sent);
  s.control = control_summary(result.safety, sent, result.frames.size(), options.judging.error_floor);
  return s;
}

namespace {

JsonKeys<TouchErrors> error_keys() {
  using E = TouchErrors;
  return {{"samples", "", "frames compared with a tight solve at their site", &E::samples},
          {"p50", "1", "median relative error of the elastic force; null: no samples", &E::p50},
          {"p95", "1", "95th percentile", &E::p95},
          {"max", "1", "largest", &E::max},
          {"within_jnd", "1", "share of the samples whose error is below the JND", &E::within_jnd}};
}

JsonKeys<TouchBars> bar_keys() {
  using B = TouchBars;
  return {{"coverage", "1", "share of the samples at equal distances inside the bar; null: no sample has one",
           &B::inside},
          {"coverage_above", "1", "the same of samples whose bar is above its floor, a tenth of the JND",
           &B::inside_above},
          {"at_floor", "", "samples whose bar is at that floor", &B::at_floor},
          {"width_p50", "N", "median half-width", &B::width}};
}

JsonKey<TouchSummary> bars_row(const std::string& name, std::size_t level) {
  return {below(name, declared(bar_keys())), [name, level](Json& document, const TouchSummary& s) {
            put(document, name, document_of(bar_keys(), s.bars[level]));
          }};
}

JsonKey<TouchSummary> errors_row(const std::string& name, TouchErrors TouchSummary::*member) {
  return {below(name, declared(error_keys())), [name, member](Json& document, const TouchSummary& s) {
            put(document, name, document_of(error_keys(), s.*member));
          }};
}

}  // namespace

const JsonKeys<TouchSummary>& touch_summary_keys() {
  using S = TouchSummary;
  static const JsonKeys<S> keys{
      {"settings.device", "", "the hand", [](const S& s) { return s.settings.device; }},
      {"settings.clock", "", "real or virtual", [](const S& s) { return s.settings.clock; }},
      {"settings.policy", "", "what was solved next", [](const S& s) { return s.settings.policy; }},
      {"settings.predictor", "", "of the tip's way", [](const S& s) { return s.settings.predictor; }},
      {"settings.workers", "", "that solved", [](const S& s) { return s.settings.workers; }},
      {"settings.seconds", "s", "length", [](const S& s) { return s.settings.seconds; }},
      {"settings.depth", "m", "to which states are placed", [](const S& s) { return s.settings.depth; }},
      {"settings.site_spacing", "m", "of the field", [](const S& s) { return s.settings.site_spacing; }},
      {"settings.friction", "1", "coefficient; left out: the tip sticks",
       [](const S& s) { return s.settings.friction; }},
      {"field.sites", "", "places whose jets at rest make the field",
       [](const S& s) { return s.field.sites; }},
      {"field.seconds", "s", "that making or reading it took", [](const S& s) { return s.field.seconds; }},
      {"field.patches", "s", "that making or reading its polynomials over the facets took",
       [](const S& s) { return s.field.patches; }},
      {"field.kept", "", "true: it was read from the cache", [](const S& s) { return s.field.kept; }},
      {"frames", "", "rendered", &S::frames},
      {"skipped", "", "frames that came a frame or more late; real clock", &S::skipped},
      {"touch.count", "", "touches that began", [](const S& s) { return s.touch.count; }},
      {"touch.time", "1", "share of the frames in touch", [](const S& s) { return s.touch.time; }},
      {"touch.slipping", "1", "share of these in which the site slid",
       [](const S& s) { return s.touch.slipping; }},
      {"touch.slid", "m", "way of the site over the surface", [](const S& s) { return s.touch.slid; }},
      {"touch.lost", "J", "by sliding, and where touches ended under force",
       [](const S& s) { return s.touch.lost; }},
      {"touch.stored", "J", "largest energy stored by body and pad",
       [](const S& s) { return s.touch.stored; }},
      {"touch.cone", "1",
       "largest relative distance of |g| / (f . n) from the coefficient while sliding on a facet, edges and "
       "the "
       "clamp's border left out",
       [](const S& s) { return s.touch.cone; }},
      {"touch.angle", "rad", "of the force to the normal: p50, p95",
       [](const S& s) { return json_numbers(s.touch.angle); }},
      {"states.start", "", "solved states known at the start", [](const S& s) { return s.states.start; }},
      {"states.jets", "", "jets at rest that were made at the hand's place",
       [](const S& s) { return s.states.jets; }},
      {"states.solved", "", "other states that were solved", [](const S& s) { return s.states.solved; }},
      {"states.failed", "", "solves that failed", [](const S& s) { return s.states.failed; }},
      {"states.preempted", "", "solves that were cancelled", [](const S& s) { return s.states.preempted; }},
      {"time_in.safe", "1", "share of the time in touch", [](const S& s) { return s.time_in[Label::safe]; }},
      {"time_in.sparse", "1", "share of the time in touch",
       [](const S& s) { return s.time_in[Label::sparse]; }},
      {"time_in.gap", "1", "share of the time in touch", [](const S& s) { return s.time_in[Label::gap]; }},
      {"time_in.blank", "1", "share of the time in touch",
       [](const S& s) { return s.time_in[Label::blank]; }},
      {"time_trusted", "1", "share of the time in touch with a trusted force", &S::time_trusted},
      errors_row("error.samples", &S::samples),
      errors_row("error.first_visit", &S::first_visit),
      errors_row("error.by_trusted.1", &S::trusted),
      errors_row("error.by_trusted.0", &S::untrusted),
      bars_row("error_bar.p90", 0),
      bars_row("error_bar.p95", 1),
      bars_row("error_bar.p99", 2),
      {"error.failed", "", "frames whose tight solve failed: there is no equilibrium, or none was found",
       &S::references_failed},
      {"switching.count", "", "models that the loop took", [](const S& s) { return s.switching.count; }},
      {"switching.over_bound", "", "frames in which the switch changed the force by more than its bound",
       [](const S& s) { return s.switching.over_bound; }},
      {"switching.max_jump", "N", "largest difference of two models where the newer one was taken",
       [](const S& s) { return s.switching.max_jump; }},
      {"safety.clamped", "", "frames cut at the force limit", [](const S& s) { return s.safety.clamped; }},
      {"safety.slewed", "", "frames held back by the slew limit", [](const S& s) { return s.safety.slewed; }},
      {"safety.stale", "", "frames in which the watchdog faded the force out",
       [](const S& s) { return s.safety.stale; }},
      {"safety.non_finite", "", "frames whose force was not finite and counted as zero",
       [](const S& s) { return s.safety.non_finite; }},
      {"safety.generated_J", "J", "largest energy that the hand got back beyond what it had put in",
       [](const S& s) { return s.safety.generated; }},
      {"safety.work_J", "J", "sum of |F . dx|", [](const S& s) { return s.safety.work; }},
      {"passivity.control", "", "true: session.passivity = \"control\"; the rest is null without it",
       [](const S& s) { return s.control.report.on; }},
      {"passivity.added_p50", "1", "force error that the control added: |sent - without| / |without|",
       [](const S& s) { return s.control.added_p50; }},
      {"passivity.added_p95", "1", "of that, the 95th percentile",
       [](const S& s) { return s.control.added_p95; }},
      {"passivity.coupling", "N/m", "largest stiffness rendered; null: no limit is known",
       [](const S& s) { return s.control.report.on ? s.control.report.coupling : unknown; }},
      {"passivity.coupled_share", "1", "frames in which the body was stiffer than that",
       [](const S& s) { return s.control.coupled_share; }},
      {"passivity.drained_share", "1", "frames in which the tank held force back",
       [](const S& s) { return s.control.drained_share; }},
      {"passivity.damped_share", "1", "frames in which the controller damped",
       [](const S& s) { return s.control.controlled_share; }},
      {"passivity.lowest_J", "J", "least energy in the tank; below zero: it could not be held",
       [](const S& s) { return s.control.report.on ? s.control.report.lowest : unknown; }},
      {"cost_us", "us", "time to compute a frame: p50, p99; real clock",
       [](const S& s) { return json_numbers(s.cost_us); }},
      {"interrupted", "", "true: the session or its judging ended early", &S::interrupted},
      {"notes", "", "what the system refused, what failed", &S::notes}};
  return keys;
}

std::vector<DeclaredTable> touch_outputs() {
  std::vector<DeclaredTable> tables = declared_touch_files();
  std::vector<Declared> rows = declared(touch_summary_keys());
  rows.push_back({"provenance.KEY", "", "", "program, machine and inputs"});
  tables.push_back({"summary.json, anywhere", "Of a session with contact.anywhere.", std::move(rows)});
  return tables;
}

}  // namespace forefeel
