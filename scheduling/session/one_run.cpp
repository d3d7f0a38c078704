#include "scheduling/session/one_run.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <optional>
#include <utility>

#include "approx/switch/relaxation.hpp"
#include "geometry/index/lattice_room.hpp"
#include "scheduling/judge/session_judge.hpp"
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
      stiffest = std::max(stiffest, state.stiffness.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff());
  if (stiffest > limits.stiffness)
    result.notes.push_back(fmt::format("the body is as stiff as {:.0f} N/m, device {} renders {:.0f} N/m",
                                       stiffest, device, limits.stiffness));
}

// Errors of first visits and the load refer to lattice cells. If no cell fits the box, neither exists.
void note_no_cells(const SessionPlan& plan, SessionResult& result) {
  const Box& box = plan.input.touched.space.box;
  const double side = visit_cell(plan.options.judging, plan.input.touched.space.spacing);
  const Eigen::Array3d low = (box.low / side).array() - 1e-9, high = (box.high / side).array() + 1e-9;
  std::string solved;
  if (!plan.arrivals.given && result.solver.seconds.empty() && result.end != RunEnd::not_begun) {
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

// Workers finish what they have begun when the loop ends, so files hold more states than the last frame knew.
void note_late_states(SessionResult& result) {
  if (result.frames.empty()) return;
  const std::size_t all = result.counts.start + result.counts.solved, seen = result.frames.back().known;
  if (all <= seen) return;
  result.notes.push_back(fmt::format(
      "{} of the {} solved states came after the last frame, which knew {}: states.csv and the file of "
      "states hold them; pictures and the replay of the run leave out what came too late for them",
      all - seen, result.counts.solved, seen));
}

// Passes each position on to the caller.
class PositionTeller final : public FrameStage {
 public:
  explicit PositionTeller(std::function<void(const Vec3&)> tell) : tell_(std::move(tell)) {}
  void frame(const PassedFrame& frame) override { tell_(frame.at); }

 private:
  std::function<void(const Vec3&)> tell_;
};

bool is_virtual(const SessionPlan& plan) {
  return plan.options.clock.kind == Clock::virtual_time;
}

void note_viscosity(const SessionPlan& plan, SessionResult& result) {
  result.notes.push_back(fmt::format(
      "viscous: the force of a held press relaxes to {:.3g} of its first value{}; errors compare with tight "
      "solves after the same relaxation",
      long_term_share(plan.render.viscosity),
      is_linear(*plan.input.touched.body) ? " (exact for this law)"
                                          : " (quasi-linear: an approximation where the law is not linear)"));
}

// Notes and warnings that are known before the first frame.
void note_start(const SessionPlan& plan, const ReferenceService& references, SessionResult& result) {
  const WorkerOptions& workers = plan.options.workers;
  if (!is_virtual(plan) && (to_text(workers.cost) != to_text(CostSpec()) || workers.latency > 0))
    result.notes.push_back("cost and latency are those of simulated workers: ignored under the real clock");
  if (plan.input.foreign)
    result.notes.push_back(fmt::format(
        "the {} known states are of another body: they alone are rendered, nothing is solved, and "
        "errors are not measured",
        plan.input.known.size()));
  for (const std::string& note : plan.motion_notes) result.notes.push_back(note);
  result.viscous = !plan.render.viscosity.empty();
  if (result.viscous) note_viscosity(plan, result);
  result.guess_softness = plan.guess.softness;
  if (!plan.guess.left_out.empty())
    result.notes.push_back(fmt::format(
        "no first guess: {}; the force is zero until the first state is solved", plan.guess.left_out));
  if (references.note()) result.notes.push_back(*references.note());
  if (references.damage() && !plan.input.references) result.warnings.push_back(*references.damage());
}

// Compares shapes with tight solves; what fails costs the run nothing else.
void check_run_shapes(ShapedRun& shapes, const SessionPlan& plan, ReferenceService& references,
                      SessionResult& result, const ShowProgress& show) {
  if (result.interrupted()) return;
  try {
    shapes.checked = check_shapes(*shapes.log, references, plan.options.stop, result, show);
  } catch (const std::exception& problem) {
    result.failures.push_back(fmt::format("shapes have no error: {}", problem.what()));
  }
}

// planner -> pipeline -> renderer (where it can follow) -> judge -> the caller's each_position
SessionResult run_and_judge(const SessionPlan& plan, ReferenceService& references, const SessionHooks& hooks,
                            ShapedRun* shapes) {
  SessionResult result;
  std::shared_ptr<const CostModel> cost = plan.input.parts.cost;
  if (is_virtual(plan) && !cost) cost = cost_model(plan, references);
  note_start(plan, references, result);
  const auto start = std::chrono::steady_clock::now();
  const std::unique_ptr<InputLog> inputs = open_inputs(plan);
  FramePipeline pipeline(plan.input.touched.space);
  std::shared_ptr<FollowingRenderer> renderer;
  if (is_virtual(plan) && !plan.device->answers_force()) {
    renderer = std::make_shared<FollowingRenderer>(pipeline.known(), plan.model, plan.render, plan.frames,
                                                   inputs.get());
    pipeline.add(renderer);
  }
  const auto judge = std::make_shared<SessionJudge>(judge_setup(plan), pipeline.known(), references);
  pipeline.add(judge);
  std::shared_ptr<ShapeStage> stage;
  if (shapes && is_virtual(plan))
    pipeline.add(stage =
                     std::make_shared<ShapeStage>(*shapes->log, pipeline.known(), plan.options.clock.frame));
  if (hooks.each_position) pipeline.add(std::make_shared<PositionTeller>(hooks.each_position));
  if (is_virtual(plan))
    run_virtual(plan, {*cost, references, pipeline, renderer.get(), inputs.get()}, result, hooks.progress);
  else
    run_real(plan, references, result, hooks.progress, {shapes ? shapes->log.get() : nullptr, inputs.get()});
  if (inputs) inputs->close();
  if (inputs && inputs->failure()) result.failures.push_back(*inputs->failure());
  if (hooks.when_run) hooks.when_run(result);
  note_late_states(result);
  note_stiffness(plan.device->limits(), to_text(plan.options.motion.device), result);
  pipeline.pass_rest(result.frames, result.states);
  try {
    pipeline.wait(hooks.progress);
    judge->finish(result, hooks.progress);
  } catch (const std::exception& problem) {  // the run itself is kept
    result.failures.push_back(fmt::format("labels and errors are incomplete: {}", problem.what()));
  }
  if (stage && stage->failure()) result.failures.push_back(*stage->failure());
  if (shapes) check_run_shapes(*shapes, plan, references, result, hooks.progress);
  if (references.cache_failure()) result.warnings.push_back(*references.cache_failure());
  note_no_cells(plan, result);
  result.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace

std::shared_ptr<ReferenceService> references_of(const SessionPlan& plan) {
  if (plan.input.references) return plan.input.references;
  ReferenceOptions options = reference_options(plan.input);
  if (plan.input.foreign) options.cache_folder.clear();  // nothing is solved, so no cache is needed
  return std::make_shared<ReferenceService>(options, plan.options.workers.threads);
}

bool adds_rest(const SessionPlan& plan) {
  const auto is_rest = [](const State& s) { return s.usable() && s.at.isZero(0); };
  return !plan.input.foreign && plan.options.planning.rest_known &&
         std::ranges::none_of(plan.input.known, is_rest);
}

SessionResult run_once(const SessionPlan& plan, const SessionHooks& hooks, ShapedRun* shapes) {
  const std::shared_ptr<ReferenceService> references = references_of(plan);
  if (!adds_rest(plan)) return run_and_judge(plan, *references, hooks, shapes);
  return run_and_judge(with_known(plan, {references->get(Vec3::Zero())}), *references, hooks, shapes);
}

}  // namespace forefeel
