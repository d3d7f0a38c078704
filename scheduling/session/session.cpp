#include "scheduling/session/session.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "geometry/common/quantiles.hpp"
#include "geometry/index/lattice_room.hpp"
#include "scheduling/session/session_parts.hpp"
#include "scheduling/workers/cost.hpp"

namespace forefeel {
namespace {

// What the device cannot render, a real one would shake at.
void note_stiffness(const DeviceLimits& limits, const std::string& device, SessionResult& result) {
  double stiffest = 0;
  for (const State& state : result.states)
    if (state.usable() && state.stiffness.allFinite())
      stiffest = std::max(stiffest, state.stiffness.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff());
  if (stiffest > limits.stiffness)
    result.notes.push_back(fmt::format("the body is as stiff as {:.0f} N/m, device {} renders {:.0f} N/m",
                                       stiffest, device, limits.stiffness));
}

// Errors of first visits and the load are of lattice cells: where none fits the box there are none, however the hand moves.
void note_no_cells(const SessionPlan& plan, SessionResult& result) {
  const Box& box = plan.input.touched.space.box;
  const double side = visit_cell(plan.options.judging, plan.input.touched.space.spacing);
  const Eigen::Array3d low = (box.low / side).array() - 1e-9, high = (box.high / side).array() + 1e-9;
  std::string solved;
  if (!plan.given_arrivals && result.solver.seconds.empty() && result.end != RunEnd::not_begun) {
    const bool none = !holds_lattice_position(box, plan.input.touched.space.spacing);
    if (result.counts.solved > 0)
      solved = "nothing but rest was solved: there is no load";
    else
      solved = none ? fmt::format(
                          "the box holds no position of the lattice of {:g} m: nothing could be solved, and "
                          "there is no load",
                          plan.input.touched.space.spacing)
                    : "nothing was solved: there is no load";
  }
  if (((high.floor() - low.ceil()) < 1).any())
    result.notes.push_back(
        fmt::format("no cell of a lattice of {:g} m fits the box: there are no first visits{}{}", side,
                    solved.empty() ? "" : "; ", solved));
  else if (!holds_lattice_position(box, plan.input.touched.space.spacing) && !solved.empty())
    result.notes.push_back(solved);
}

std::shared_ptr<ReferenceService> own_references(const SessionInput& input, const SessionOptions& options) {
  return std::make_shared<ReferenceService>(reference_options(input), options.workers.threads);
}

}  // namespace

std::unique_ptr<StateWriter> open_state_file(const SessionInput& input) {
  if (!input.files.states) return nullptr;
  return std::make_unique<StateWriter>(
      StateFile::open_or_create(*input.files.states, {.identity = input.touched.identity,
                                                      .spacing = input.touched.space.spacing,
                                                      .box = input.touched.space.box,
                                                      .notes = {}}));
}

Planner::Hooks hooks_of(const SessionPlan& plan, const CostModel* cost, StateWriter* writer) {
  Planner::Hooks hooks;
  if (writer) hooks.on_state = [writer](const State& state) { writer->push(state); };
  if (!plan.motion.empty())
    hooks.future = [&motion = plan.motion, frame = plan.options.clock.frame](double t) {
      const auto k = static_cast<std::size_t>(std::max(0LL, std::llround(t / frame)));
      return motion[std::min(k, motion.size() - 1)];
    };
  if (cost) {  // a body that has been solved before: its median is known
    std::vector<double> seconds;
    for (const Vec3& x :
         lattice(plan.input.touched.space.box, plan.input.touched.space.box.size().maxCoeff() / 4))
      seconds.push_back(cost->seconds(x));
    if (!seconds.empty()) hooks.expected_solve = median(std::move(seconds));
  }
  return hooks;
}

void take_loop(RenderLoop& loop, std::size_t frames, SessionResult& result) {
  result.frames = loop.take_log();
  if (result.frames.size() < frames) {
    result.end = RunEnd::interrupted;
    result.notes.push_back(fmt::format("interrupted after {} of {} frames", result.frames.size(), frames));
  }
  const SafetyCounts& counts = loop.safety().counts();
  result.safety = {.clamped = counts.clamped,
                   .slewed = counts.slewed,
                   .stale = counts.stale,
                   .non_finite = counts.non_finite,
                   .generated = loop.safety().generated(),
                   .work = loop.safety().work()};
  if (counts.clamped > 0)
    result.notes.push_back(fmt::format(
        "{} of {} frames were clamped by safety: the device got less force than was rendered; the error is "
        "that of the rendered force",
        counts.clamped, result.frames.size()));
}

ReferenceOptions reference_options(const SessionInput& input) {
  const TouchedBody& touched = input.touched;
  return {.body = touched.body,
          .identity = touched.identity,
          .spacing = touched.space.spacing,
          .box = touched.space.box,
          .displacements = touched.displacements,
          .cache_folder = input.files.cache};
}

void check_session(const SessionInput& input, const SessionOptions& options) {
  make_plan(input, options);
}

double motion_seconds(const SessionInput& input, const SessionOptions& options) {
  return make_plan(input, options).device->duration();
}

namespace {

// Share of first visits within the JND; less than none where there are none.
double first_visits_within(const SessionResult& result, const SwitchOptions& jnd) {
  std::size_t visits = 0, within = 0;
  for (const FrameRecord& f : result.frames) {
    if (!f.judged.first_visit || !std::isfinite(f.judged.error)) continue;
    ++visits;
    within += (f.force - f.judged.reference).norm() <=
              std::max(jnd.jnd_share * f.judged.reference.norm(), jnd.jnd_floor);
  }
  return visits > 0 ? static_cast<double>(within) / static_cast<double>(visits) : -1.0;
}

// What an interrupted rehearsal leaves of the session: nothing was rendered, nothing solved that counts.
SessionResult not_begun(const SessionInput& input, std::string note) {
  open_state_file(input);
  SessionResult result;
  StateSpace space(input.touched.space);
  for (const State& state : input.known)
    if (state.usable() && space.insert(state).is_new) result.states.push_back(state);
  result.counts.start = result.states.size();
  result.end = RunEnd::not_begun;
  result.notes.push_back(std::move(note));
  return result;
}

// Who knows the motion and what each solve will cost can try the session before it counts: under every policy but the
// placebos, with the motion known and without. The best at first visits is then run.
SessionResult run_rehearsed(SessionInput input, SessionOptions options, const ShowProgress& show,
                            const std::function<void(const SessionResult&)>& when_run,
                            const std::function<void(const Vec3&)>& each_position) {
  const auto start = std::chrono::steady_clock::now();
  const auto seconds_since_start = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const bool own = !input.references;
  if (own) input.references = own_references(input, options);
  const auto state_file = std::exchange(input.files.states, std::nullopt);
  std::vector<std::string> schedules = policy_names();
  std::erase_if(schedules, [](const std::string& name) {
    return name == "clairvoyant" || name.find("shuffled") != std::string::npos;
  });
  std::string best = "clairvoyant-greedy";
  std::stable_partition(schedules.begin(), schedules.end(),
                        [&](const std::string& name) { return name == best; });
  double most = -2;
  std::size_t rehearsed = 0;
  for (std::size_t i = 0; i < schedules.size() && most < 1; ++i, ++rehearsed) {  // nothing is better than all
    const std::string& name = schedules[i];
    options.planning.policy = name;
    ShowProgress rehearsal;
    if (show)
      rehearsal = [&](SessionProgress p) {
        p.rehearsal = i + 1;
        p.rehearsals = schedules.size();
        show(p);
      };
    const SessionResult tried = run_session(input, options, rehearsal);
    if (options.stop.is_interrupted()) {
      input.files.states = state_file;
      SessionResult result = not_begun(
          input,
          fmt::format("interrupted while it rehearses, in schedule {} of {}: the session itself was not "
                      "begun",
                      i + 1, schedules.size()));
      if (when_run) when_run(result);
      result.wall_seconds = seconds_since_start();
      return result;
    }
    const double share = first_visits_within(tried, options.switching);
    if (share > most) {
      most = share;
      best = name;
    }
  }
  options.planning.policy = best;
  input.files.states = state_file;
  SessionResult result = run_session(input, options, show, when_run, each_position);
  if (own && input.references->damage()) result.warnings.push_back(*input.references->damage());
  result.notes.push_back(fmt::format(
      "clairvoyant: {} was the best of {} schedules that were rehearsed{}", best, rehearsed,
      rehearsed < schedules.size() ? ": all first visits are within the JND, none can be better" : ""));
  return result;
}

}  // namespace

SessionResult run_session(const SessionInput& given, const SessionOptions& options, const ShowProgress& show,
                          const std::function<void(const SessionResult&)>& when_run,
                          const std::function<void(const Vec3&)>& each_position) {
  const bool is_virtual = options.clock.kind == Clock::virtual_time;
  SessionPlan plan = make_plan(given, options);
  if (is_rehearsed(plan)) return run_rehearsed(given, options, show, when_run, each_position);
  const std::shared_ptr<ReferenceService> shared =
      given.references ? given.references : own_references(given, options);
  ReferenceService& references = *shared;
  if (options.planning.rest_known &&
      std::ranges::none_of(given.known, [](const State& s) { return s.usable() && s.at.isZero(0); }))
    plan = with_known(std::move(plan), {references.get(Vec3::Zero())});
  SessionResult result;
  if (!is_virtual && (to_text(options.workers.cost) != to_text(CostSpec()) || options.workers.latency > 0))
    result.notes.push_back("cost and latency are those of simulated workers: ignored under the real clock");
  std::shared_ptr<const CostModel> cost = given.parts.cost;
  if (is_virtual && !cost) cost = cost_model(plan, references);
  if (references.note()) result.notes.push_back(*references.note());
  if (references.damage() && !given.references) result.warnings.push_back(*references.damage());
  const auto start = std::chrono::steady_clock::now();
  RunAnalysis analysis(judge_setup(plan), references, each_position);
  if (is_virtual)
    run_virtual(plan, *cost, references, analysis, result, show);
  else
    run_real(plan, references, result, show);
  if (when_run) when_run(result);
  note_stiffness(plan.device->limits(), to_text(options.motion.device), result);
  analysis.finish(result, show);
  note_no_cells(plan, result);
  result.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace forefeel
