// Runs a planned session: once, or after rehearsals (a clairvoyant one), with shapes or without.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "approx/model/lattice_field.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/dense.hpp"
#include "geometry/common/error.hpp"
#include "geometry/index/lattice_room.hpp"
#include "scheduling/judge/surface_judge.hpp"
#include "scheduling/render/input_log.hpp"
#include "scheduling/session/real_run.hpp"
#include "scheduling/session/run_parts.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/session/session_setup.hpp"
#include "scheduling/session/shaped_session.hpp"
#include "scheduling/session/virtual_run.hpp"
#include "scheduling/shape/shape_thread.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {
namespace {

// A device vibrates at a stiffness that it cannot render.
void note_stiffness(const DeviceLimits& limits, const std::string& device, SessionResult& result) {
  double stiffest = 0;
  for (const State& state : result.states)
    if (state.usable() && state.stiffness.allFinite())
      stiffest = std::max(stiffest, axes_of(state.stiffness).values[2]);
  if (stiffest > limits.stiffness)
    result.notes.push_back(fmt::format("the body is as stiff as {:.0f} N/m, device {} renders {:.0f} N/m",
                                       stiffest, device, limits.stiffness));
}

// Why there is no load, if nothing was solved; else empty.
std::string unsolved_in_words(const StateSpaceOptions& space, const SessionResult& result) {
  if (!result.solver.seconds.empty() || result.run.end == RunEnd::not_begun) return {};
  if (result.counts.solved > 0) return "nothing but rest was solved: there is no load";
  if (holds_lattice_position(space.box, space.spacing)) return "nothing was solved: there is no load";
  return fmt::format(
      "the box holds no position of the lattice of {:g} m: nothing could be solved, and there is no load",
      space.spacing);
}

// Errors of first visits and the load refer to lattice cells. If no cell fits the box, neither exists.
void note_no_cells(const RunBounds& bounds, bool dispatches, SessionResult& result) {
  const Box& box = bounds.space.box;
  const double side = bounds.visit_cell;
  const Eigen::Array3d low = (box.low / side).array() - 1e-9, high = (box.high / side).array() + 1e-9;
  const std::string unsolved = dispatches ? unsolved_in_words(bounds.space, result) : std::string();
  if (((high.floor() - low.ceil()) < 1).any())
    result.notes.push_back(
        fmt::format("no cell of a lattice of {:g} m fits the box: there are no first visits{}{}", side,
                    unsolved.empty() ? "" : "; ", unsolved));
  else if (!unsolved.empty() && !holds_lattice_position(box, bounds.space.spacing))
    result.notes.push_back(unsolved);
}

// Workers finish what they have begun when the loop ends, so files hold more states than the last frame knew.
void note_late_states(SessionResult& result) {
  if (result.frames.empty()) return;
  const std::size_t all = result.counts.start + result.counts.solved, seen = result.frames.back().known;
  if (all <= seen) return;
  result.notes.push_back(
      fmt::format("{} of {} came after the last frame, which knew {}: states.csv and the file of "
                  "states hold them; pictures of the run leave out what came too late for them",
                  all - seen, counted(result.counts.solved, "solved state"), seen));
}

// Frames at which a lattice method had no cell to interpolate in. The states known first come first.
void note_cells(const ModelRecipe& model, double spacing, SessionResult& result) {
  if (model.method == SessionMethod::rbf) return;
  LatticeCells cells(spacing);
  std::size_t added = 0, without = 0;
  for (const FrameRecord& frame : result.frames) {
    for (; added < std::min<std::size_t>(frame.known, result.states.size()); ++added)
      if (result.states[added].usable()) cells.add(result.states[added].at);
    without += !cells.around(frame.at);
  }
  if (without > 0)
    result.notes.push_back(
        fmt::format("in {} of {} no full lattice cell of known states was about the tip: {}", without,
                    counted(result.frames.size(), "frame"), instead_of_cells));
}

// What is particular of a session that touched a body anywhere.
void note_touches(SessionResult& result) {
  constexpr double far = 0.002, times = 10;  // [m], and over the way of the tip
  std::size_t unfelt = 0, jumps = 0;
  double farthest = 0;
  bool touched = false;
  const FrameRecord* before = nullptr;
  for (const FrameRecord& frame : result.frames) {
    const bool holds = frame.touch.kind != TouchKind::none;
    touched |= holds;
    unfelt += !holds && frame.touch.inside;
    if (holds && before && before->touch.kind != TouchKind::none) {
      const double way = (frame.touch.site.at - before->touch.site.at).norm();
      const bool jumped = way >= far + times * (frame.at - before->at).norm();
      if (jumped) ++jumps, farthest = std::max(farthest, way);
    }
    before = &frame;
  }
  if (!touched) result.notes.push_back("the tip never entered the body");
  if (unfelt > 0)
    result.notes.push_back(
        fmt::format("in {} the tip was inside the body and felt nothing: it had come "
                    "through the clamp, or a touch had ended there under tension",
                    counted(unfelt, "frame")));
  if (jumps > 0)
    result.notes.push_back(
        fmt::format("the site jumped in {}, by up to {:.1f} mm: the body snaps under the tip there, or the "
                    "model is wrong",
                    counted(jumps, "frame"), 1e3 * farthest));
}

// Passes each position on to the caller.
class PositionTeller final : public FrameStage {
 public:
  explicit PositionTeller(std::function<void(const Vec3&)> tell) : tell_(std::move(tell)) {}
  void frame(const PassedFrame& frame) override { tell_(frame.at); }

 private:
  std::function<void(const Vec3&)> tell_;
};

// Compares shapes with tight solves; what fails costs the run nothing else.
void check_run_shapes(ShapedRun& shapes, const StopOptions& stop, ReferenceService& references,
                      SessionResult& result, const ShowProgress& show) {
  if (result.interrupted()) return;
  try {
    shapes.checked = check_shapes(*shapes.log, references, stop, result, show);
  } catch (const std::exception& problem) {
    result.failures.push_back(fmt::format("shapes have no error: {}", problem.what()));
  }
}

// planner -> pipeline -> renderer (where it can follow) -> judge -> the caller's each_position
SessionResult run_and_judge(const RunSetup& setup, ReferenceService& references, const SessionHooks& hooks,
                            ShapedRun* shapes) {
  SessionResult result;
  result.run = setup.report;
  result.notes = setup.notes;
  if (references.note()) result.notes.push_back(*references.note());
  const auto start = std::chrono::steady_clock::now();
  const bool is_virtual = setup.motion.clock.kind == Clock::virtual_time;
  const std::unique_ptr<InputLog> inputs = open_inputs(setup.record);
  SurfaceModels* const surface = setup.rendering.surface.get();
  FramePipeline pipeline(setup.bounds.space);
  std::shared_ptr<FollowingRenderer> renderer;
  if (is_virtual && !setup.motion.device->answers_force() && !surface) {
    renderer = std::make_shared<FollowingRenderer>(pipeline.known(), setup.rendering, setup.motion.frames,
                                                   inputs.get());
    pipeline.add(renderer);
  }
  std::shared_ptr<SessionJudge> judge;
  if (!surface)
    pipeline.add(judge = std::make_shared<SessionJudge>(setup.judging, pipeline.known(), references));
  std::shared_ptr<ShapeStage> stage;
  if (shapes && is_virtual && !surface)
    pipeline.add(stage =
                     std::make_shared<ShapeStage>(*shapes->log, pipeline.known(), setup.motion.clock.frame));
  if (hooks.each_position) pipeline.add(std::make_shared<PositionTeller>(hooks.each_position));
  if (is_virtual)
    run_virtual(setup, {references, pipeline, renderer.get(), inputs.get()}, result, hooks.progress);
  else
    run_real(setup, references, result, hooks.progress,
             {shapes && !surface ? shapes->log.get() : nullptr, inputs.get()});
  if (inputs) inputs->close();
  if (inputs && inputs->failure()) result.failures.push_back(*inputs->failure());
  if (hooks.when_run) hooks.when_run(result);
  note_late_states(result);
  if (!surface) note_cells(setup.rendering.model, setup.bounds.space.spacing, result);
  note_stiffness(setup.motion.device->limits(), setup.motion.name, result);
  if (surface) note_touches(result);
  if (surface && shapes)
    if (const auto failure = take_shapes(*shapes->log, result.frames, surface->known()))
      result.failures.push_back(*failure);
  pipeline.pass_rest(result.frames, surface ? std::span<const State>() : result.states);
  try {
    pipeline.wait(hooks.progress);
    if (judge)
      judge->finish(result, hooks.progress);
    else
      judge_surface(*surface, setup.judging, setup.bounds.space, references,
                    reference_threads(setup.solving.options.threads), result, hooks.progress);
  } catch (const std::exception& problem) {  // the run itself is kept
    result.failures.push_back(fmt::format("labels and errors are incomplete: {}", problem.what()));
  }
  if (stage && stage->failure()) result.failures.push_back(*stage->failure());
  if (shapes) check_run_shapes(*shapes, setup.motion.stop, references, result, hooks.progress);
  if (references.cache_failure()) result.warnings.push_back(*references.cache_failure());
  if (!surface) note_no_cells(setup.bounds, setup.solving.dispatches, result);
  result.run.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

// The reference service given in the input; otherwise a new one.
std::shared_ptr<ReferenceService> references_of(const SessionInput& input, const WorkerOptions& workers) {
  if (input.references) return input.references;
  ReferenceOptions options = reference_options(input);
  if (input.foreign) options.cache_folder.clear();  // nothing is solved, so no cache is needed
  return std::make_shared<ReferenceService>(options, workers.threads);
}

// Whether the state at rest must be known from the start but is not among the known states. If so, run_once() appends
// it to them.
bool adds_rest(const SessionInput& input, const SessionOptions& options) {
  const auto is_rest = [](const State& s) { return s.usable() && s.at.isZero(0); };
  const bool jets = options.model.fit.data == Data::jet && options.model.method == SessionMethod::rbf;
  return !input.foreign && !input.touched.anywhere && (options.planning.rest_known || jets) &&
         std::ranges::none_of(input.known, is_rest);
}

// Without rehearsals. shapes: null without them.
SessionResult run_once(const SessionPlan& plan, const SessionHooks& hooks, ShapedRun* shapes = nullptr) {
  const std::shared_ptr<ReferenceService> references = references_of(plan.input, plan.options.workers);
  const auto run = [&](const SessionPlan& whole) {
    return run_and_judge(divide(whole, *references), *references, hooks, shapes);
  };
  SessionResult result = adds_rest(plan.input, plan.options)
                             ? run(with_known(plan, {references->get(Vec3::Zero())}))
                             : run(plan);
  if (references->damage() && !plan.input.references)
    result.warnings.insert(result.warnings.begin(), *references->damage());
  return result;
}

// ---- clairvoyant sessions

// An upper bound of what a policy can reach. The motion and the cost of every solve are known, so the session can be
// simulated in advance (rehearsed). It is simulated under every policy except the placebos, with and without knowledge
// of the motion. Then the schedule with the largest share of first visits within the JND (just noticeable difference)
// is run. All this takes up to about twenty times as long as one run.

// The policies that are rehearsed, clairvoyant-greedy first: it is usually the best.
std::vector<std::string> schedules_to_rehearse() {
  std::vector<std::string> names = policy_names();
  std::erase_if(names, [](const std::string& name) { return name == "clairvoyant" || is_placebo(name); });
  std::stable_partition(names.begin(), names.end(),
                        [](const std::string& name) { return name == "clairvoyant-greedy"; });
  return names;
}

// Share of first visits within the JND; negative if there are no first visits.
double first_visits_within(const SessionResult& result, const SwitchOptions& jnd) {
  std::size_t visits = 0, within = 0;
  for (const FrameRecord& f : result.frames) {
    if (!f.judged.first_visit || !std::isfinite(f.judged.error)) continue;
    ++visits;
    within += (compared_force(f) - f.judged.reference).norm() <=
              std::max(jnd.jnd_share * f.judged.reference.norm(), jnd.jnd_floor);
  }
  return visits > 0 ? static_cast<double>(within) / static_cast<double>(visits) : -1.0;
}

ShowProgress as_rehearsal(const ShowProgress& show, std::size_t which, std::size_t of) {
  if (!show) return {};
  return [&show, which, of](SessionProgress progress) {
    progress.rehearsal = which;
    progress.rehearsals = of;
    show(progress);
  };
}

// The result of a session that was interrupted during a rehearsal: no frames and no solves.
// with_rest: its first states end with one at rest that the plan does not hold.
SessionResult not_begun(SessionResult tried, bool with_rest, std::string note) {
  SessionResult result;
  tried.states.resize(tried.counts.start - (with_rest ? 1 : 0));
  result.states = std::move(tried.states);
  result.counts.start = result.states.size();
  result.run.end = RunEnd::not_begun;
  result.notes.push_back(std::move(note));
  return result;
}

struct Rehearsals {
  std::string best;
  std::size_t tried = 0, of = 0;     // schedules
  std::optional<SessionResult> cut;  // of the rehearsal that was interrupted
};

Rehearsals rehearse(const SessionPlan& plan, const ShowProgress& show) {
  const std::vector<std::string> schedules = schedules_to_rehearse();
  Rehearsals found{.best = schedules.front(), .of = schedules.size(), .cut = {}};
  double most = -2;
  for (; found.tried < schedules.size() && most < 1; ++found.tried) {  // a share of 1 cannot be exceeded
    const std::string& name = schedules[found.tried];
    SessionResult result = run_once(with_policy(plan, name),
                                    {.progress = as_rehearsal(show, found.tried + 1, schedules.size())});
    if (plan.options.stop.is_interrupted()) {
      found.cut = std::move(result);
      return found;
    }
    if (!result.failures.empty()) throw std::runtime_error(result.failures.front());
    const double share = first_visits_within(result, plan.options.switching);
    if (share > most) {
      most = share;
      found.best = name;
    }
  }
  return found;
}

// shapes: of the session itself.
SessionResult run_rehearsed(SessionPlan plan, const SessionHooks& hooks, ShapedRun* shapes = nullptr) {
  const auto start = std::chrono::steady_clock::now();
  const bool own = !plan.input.references;
  plan.input.references = references_of(plan.input, plan.options.workers);  // one for all rehearsals
  const auto state_file = std::exchange(plan.input.files.states, std::nullopt);
  const auto inputs_file = std::exchange(plan.input.files.inputs, std::nullopt);
  Rehearsals rehearsed = rehearse(plan, hooks.progress);
  plan.input.files.states = state_file;
  plan.input.files.inputs = inputs_file;
  if (rehearsed.cut) {
    open_state_file(state_file, states_header(plan.input.touched));
    SessionResult result = not_begun(
        std::move(*rehearsed.cut), adds_rest(plan.input, plan.options),
        fmt::format("interrupted while simulating schedule {} of {}: the session itself was not begun",
                    rehearsed.tried + 1, rehearsed.of));
    if (hooks.when_run) hooks.when_run(result);
    result.run.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
  }
  const std::shared_ptr<ReferenceService> references = plan.input.references;
  SessionResult result = run_once(with_policy(std::move(plan), rehearsed.best), hooks, shapes);
  if (own && references->damage()) result.warnings.push_back(*references->damage());
  result.notes.push_back(fmt::format(
      "clairvoyant: {} was the best of {} schedules that were simulated{}", rehearsed.best, rehearsed.tried,
      rehearsed.tried < rehearsed.of ? ": all first visits are within the JND, none can be better" : ""));
  return result;
}

}  // namespace

SessionResult run_session(const SessionPlan& plan, const SessionHooks& hooks, ShapedRun* shapes) {
  if (!shapes) return run_session(plan, hooks);
  if (plan.input.foreign)
    throw InputError("session.shape_rate", "needs states of the scene's own body, expected none of another");
  if (!plan.input.touched.displacements)
    throw InputError("session.shape_rate",
                     "needs states that hold displacements (state_space.displacements)");
  check_shapeable(plan.input.known, *plan.input.touched.body, "the known states");
  return is_rehearsed(plan) ? run_rehearsed(plan, hooks, shapes) : run_once(plan, hooks, shapes);
}

SessionResult run_session(const SessionPlan& plan, const SessionHooks& hooks) {
  return is_rehearsed(plan) ? run_rehearsed(plan, hooks) : run_once(plan, hooks);
}

SessionResult run_session(SessionInput input, SessionOptions options, const SessionHooks& hooks) {
  return run_session(make_plan(std::move(input), std::move(options)), hooks);
}

}  // namespace forefeel
