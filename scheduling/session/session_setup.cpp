#include "scheduling/session/session_setup.hpp"

#include <fmt/format.h>

#include <utility>

#include "approx/switch/relaxation.hpp"
#include "geometry/coverage/state_space.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/session/input_replay.hpp"
#include "scheduling/touch/surface_contact.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "solver/body/body.hpp"
#include "solver/body/contact_stiffness.hpp"

namespace forefeel {
namespace {

RunMotion motion_of(const SessionPlan& plan) {
  return {.device = plan.device,
          .name = to_text(plan.options.motion.device),
          .clock = plan.options.clock,
          .stop = plan.options.stop,
          .frames = plan.frames,
          .known = plan.motion};
}

std::shared_ptr<const CostModel> cost_of(const SessionPlan& plan, ReferenceService& references) {
  if (plan.options.clock.kind != Clock::virtual_time) return nullptr;
  if (plan.input.parts.cost) return plan.input.parts.cost;
  const FactoryContext context = factory_context(plan.input, plan.options.seed);
  if (plan.input.foreign) return make_cost(CostSpec(), context, {});  // no solve is measured
  return make_cost(plan.options.workers.cost, context, [&] { return references.recorded_costs(); });
}

RunSolving solving_of(const SessionPlan& plan, ReferenceService& references) {
  const TouchedBody& touched = plan.input.touched;
  const WorkerOptions& options = plan.options.workers;
  return {.options = options,
          .context = {.body = touched.body,
                      .solving = {.spacing = touched.space.spacing,
                                  .tolerance = 1e-6,
                                  .displacements = touched.displacements,
                                  .jet = touched.jet,
                                  .sites = sites_of(touched)},
                      .count = options.count},
          .real = plan.input.parts.workers,
          .simulated = plan.input.parts.virtual_workers,
          .cost = cost_of(plan, references),
          .rest_first = plan.options.planning.rest_first,
          .arrivals = plan.arrivals.list,
          .dispatches = !plan.arrivals.given};
}

RunRecord record_of(const SessionPlan& plan) {
  const TouchedBody& touched = plan.input.touched;
  const SessionFiles& files = plan.input.files;
  const bool real = plan.options.clock.kind == Clock::real;
  return {.states = files.states,
          .inputs = plan.options.record ? files.inputs : std::nullopt,
          .states_header = states_header(touched),
          .inputs_header = {.made_by = inputs_made_by(files.program),
                            .real = real,
                            .frames = plan.frames,
                            .spare = real ? spare_frames : 0,
                            .render = plan.render,
                            .model = plan.model,
                            .space = touched.space,
                            .surface = touched.anywhere ? settings_in_words(touched) : std::string()}};
}

std::string viscosity_in_words(const TouchedBody& touched) {
  return fmt::format(
      "viscous: the force of a held press relaxes to {:.3g} of its first value{}; errors compare with tight "
      "solves after the same relaxation",
      long_term_share(touched.viscosity),
      is_linear(*touched.body) ? " (exact for this law)"
                               : " (quasi-linear: an approximation where the law is not linear)");
}

// Under a pad that fits on a facet the stiffness is that of nodes and facets, not of the body.
std::optional<std::string> small_pad(const TouchTask& task) {
  const RestSites& rest = task.field->rest();
  double edges = 0;
  std::size_t count = 0;
  for (std::size_t f = 0; f < rest.map().facets().size(); ++f) {
    if (rest.map().facets()[f].clamped) continue;
    const std::array<Vec3, 3> corner = rest.map().corners(static_cast<std::int32_t>(f));
    for (std::size_t i = 0; i < 3; ++i) edges += (corner[(i + 1) % 3] - corner[i]).norm(), ++count;
  }
  const double edge = edges / static_cast<double>(std::max<std::size_t>(1, count));
  const double across = 2 * rest.pad().radius();
  if (!(across < edge)) return {};
  return fmt::format(
      "the pad is {:.2g} mm across, less than the facets' edges, {:.2g} mm in the mean: a slide may stick "
      "and slip "
      "from facet to facet; more elements or a larger contact.radius avoid that",
      1e3 * across, 1e3 * edge);
}

// What is known before the first frame.
std::vector<std::string> notes_of(const SessionPlan& plan) {
  const WorkerOptions& workers = plan.options.workers;
  std::vector<std::string> notes;
  if (plan.options.clock.kind == Clock::real &&
      (to_text(workers.cost) != to_text(CostSpec()) || workers.latency > 0))
    notes.push_back("cost and latency are those of simulated workers: ignored under the real clock");
  if (plan.input.foreign)
    notes.push_back(fmt::format(
        "the {} known states are of another body: {}; nothing is solved, and errors are not measured",
        plan.input.known.size(),
        plan.input.touched.anywhere
            ? "they correct the field of this body about their own sites and depths, and elsewhere "
              "this body is rendered"
            : "they alone are rendered"));
  notes.insert(notes.end(), plan.motion_notes.begin(), plan.motion_notes.end());
  if (plan.input.touched.anywhere)
    if (auto note = small_pad(*plan.input.touched.anywhere)) notes.push_back(std::move(*note));
  if (!plan.input.touched.viscosity.empty()) notes.push_back(viscosity_in_words(plan.input.touched));
  if (!plan.guess.left_out.empty())
    notes.push_back(fmt::format("no first guess: {}; the force is zero until the first state is solved",
                                plan.guess.left_out));
  return notes;
}

}  // namespace

bool is_rehearsed(const SessionPlan& plan) {
  const SessionOptions& options = plan.options;
  return options.planning.policy.name == "clairvoyant" && !plan.input.parts.policy &&
         options.clock.kind == Clock::virtual_time && !options.planning.arrivals && !options.motion.replay &&
         !plan.input.foreign;
}

FactoryContext factory_context(const SessionInput& input, std::uint64_t seed) {
  return {.box = input.touched.space.box,
          .inward = input.touched.inward,
          .seed = seed,
          .folder = input.files.scene,
          .surface = input.touched.anywhere ? input.touched.anywhere->surface.get() : nullptr};
}

std::shared_ptr<Policy> policy_of(const SessionInput& input, const SessionOptions& options) {
  if (input.parts.policy) return input.parts.policy;
  return make_policy(options.planning.policy, factory_context(input, options.seed));
}

std::shared_ptr<Predictor> predictor_of(const SessionInput& input, const SessionOptions& options) {
  if (input.parts.predictor) return input.parts.predictor;
  return make_predictor(options.motion.predictor, factory_context(input, options.seed));
}

std::vector<double> coarse_costs(const CostModel& cost, const Box& box) {
  std::vector<double> seconds;
  for (const Vec3& x : lattice(box, box.size().maxCoeff() / 4)) seconds.push_back(checked_seconds(cost, x));
  return seconds;
}

StateFileHeader states_header(const TouchedBody& touched) {
  return {
      .identity = touched.identity, .spacing = touched.space.spacing, .box = touched.space.box, .notes = {}};
}

RunSetup divide(const SessionPlan& plan, ReferenceService& references) {
  const StateSpaceOptions& space = plan.input.touched.space;
  const std::shared_ptr<SurfaceModels> surface =
      plan.input.touched.anywhere ? std::make_shared<SurfaceModels>(plan.input.touched.anywhere) : nullptr;
  PlannerSetup planning = planner_setup(plan);
  planning.surface = surface;
  return {.motion = motion_of(plan),
          .planning = std::move(planning),
          .solving = solving_of(plan, references),
          .rendering = {.options = plan.render, .model = plan.model, .surface = surface},
          .judging = judge_setup(plan),
          .record = record_of(plan),
          .bounds = {.space = space, .visit_cell = visit_cell(plan.options.judging, space.spacing)},
          .report = {.guess_softness = plan.guess.softness, .viscous = !plan.input.touched.viscosity.empty()},
          .notes = notes_of(plan)};
}

std::unique_ptr<ModelMaker> RunRendering::maker(const StateSpace& known, LoopLink& link) const {
  if (surface) return std::make_unique<SurfaceMaker>(surface, link);
  return std::make_unique<ModelKeeper>(known, model, link);
}

std::unique_ptr<Contact> RunRendering::contact(LoopLink& link) const {
  if (surface) return std::make_unique<SurfaceContact>(surface->task(), link, options.switching);
  return std::make_unique<Grasp>(link, options.switching);
}

PlannerSetup planner_setup(const SessionPlan& plan) {
  const Body& body = *plan.input.touched.body;
  return {
      .space = plan.input.touched.space,
      .known = plan.input.known,
      .body = {.nodes = body.mesh.nodes.size(),
               .stiffest = plan.input.touched.anywhere ? Mat3(Mat3::Zero()) : contact_stiffness_bound(body)},
      .options = plan.options.planning,
      .policy = policy_of(plan.input, plan.options),
      .predictor = predictor_of(plan.input, plan.options),
      .latency = plan.options.workers.latency,
      .model = plan.model,
      .jnd = plan.options.switching,
      .seed = plan.options.seed};
}

JudgeSetup judge_setup(const SessionPlan& plan) {
  return {.model = plan.model,
          .judging = plan.options.judging,
          .stop = plan.options.stop,
          .viscosity = plan.input.touched.viscosity,
          .jnd = plan.options.switching,
          .errors = !plan.input.foreign};
}

}  // namespace forefeel
