#include "scheduling/session/one_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <optional>
#include <span>
#include <utility>

#include "geometry/common/dense.hpp"
#include "geometry/index/lattice_room.hpp"
#include "scheduling/judge/surface_judge.hpp"
#include "scheduling/render/input_log.hpp"
#include "scheduling/session/real_run.hpp"
#include "scheduling/session/run_parts.hpp"
#include "scheduling/session/session_setup.hpp"
#include "scheduling/session/shaped_run.hpp"
#include "scheduling/session/virtual_run.hpp"
#include "scheduling/shape/shape_stage.hpp"
#include "scheduling/workers/cost.hpp"

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
  result.notes.push_back(fmt::format(
      "{} of the {} solved states came after the last frame, which knew {}: states.csv and the file of "
      "states hold them; pictures of the run leave out what came too late for them",
      all - seen, result.counts.solved, seen));
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
        fmt::format("in {} frames the tip was inside the body and felt nothing: it had come "
                    "through the clamp, or a touch had ended there under tension",
                    unfelt));
  if (jumps > 0)
    result.notes.push_back(fmt::format(
        "the site jumped in {} frames, by up to {:.1f} mm: the body snaps under the tip there, or the "
        "model is wrong",
        jumps, 1e3 * farthest));
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
  if (shapes && is_virtual)
    pipeline.add(stage =
                     std::make_shared<ShapeStage>(*shapes->log, pipeline.known(), setup.motion.clock.frame));
  if (hooks.each_position) pipeline.add(std::make_shared<PositionTeller>(hooks.each_position));
  if (is_virtual)
    run_virtual(setup, {references, pipeline, renderer.get(), inputs.get()}, result, hooks.progress);
  else
    run_real(setup, references, result, hooks.progress, {shapes ? shapes->log.get() : nullptr, inputs.get()});
  if (inputs) inputs->close();
  if (inputs && inputs->failure()) result.failures.push_back(*inputs->failure());
  if (hooks.when_run) hooks.when_run(result);
  note_late_states(result);
  note_stiffness(setup.motion.device->limits(), setup.motion.name, result);
  if (surface) note_touches(result);
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

}  // namespace

std::shared_ptr<ReferenceService> references_of(const SessionInput& input, const WorkerOptions& workers) {
  if (input.references) return input.references;
  ReferenceOptions options = reference_options(input);
  if (input.foreign) options.cache_folder.clear();  // nothing is solved, so no cache is needed
  return std::make_shared<ReferenceService>(options, workers.threads);
}

bool adds_rest(const SessionInput& input, const SessionOptions& options) {
  const auto is_rest = [](const State& s) { return s.usable() && s.at.isZero(0); };
  const bool jets = options.model.fit.data == Data::jet && options.model.method == SessionMethod::rbf;
  return !input.foreign && !input.touched.anywhere && (options.planning.rest_known || jets) &&
         std::ranges::none_of(input.known, is_rest);
}

SessionResult run_once(const SessionPlan& plan, const SessionHooks& hooks, ShapedRun* shapes) {
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

}  // namespace forefeel
