#include "scheduling/session/session_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "approx/model/model_options.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/memory.hpp"
#include "geometry/coverage/design.hpp"
#include "geometry/states/energy_jet.hpp"
#include "scheduling/common/option_check.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/trace_check.hpp"
#include "scheduling/motion/trace_file.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/session/memory_need.hpp"
#include "scheduling/session/passivity_plan.hpp"
#include "scheduling/session/session_setup.hpp"
#include "scheduling/touch/surface_models.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/generator.hpp"
#include "solver/equilibrium/first_guess.hpp"

namespace forefeel {
namespace {

// Upper bound of the distance from rest of any state of the body [m].
double farthest_place(const Body& body) {
  return 2 * bounding_box(body.mesh).size().maxCoeff();
}

// Upper bound of the number of states in the session. `path` places states half a spacing apart; at most 12
// of them fit into the volume of one lattice state.
std::size_t most_states(const SessionPlan& plan) {
  const StateSpaceOptions& space = plan.input.touched.space;
  const double listed = space.listed ? static_cast<double>(space.listed->size()) : 0;
  const double positions = std::max(((space.box.size() / space.spacing).array().floor() + 2).prod(), listed);
  const double placed =
      plan.arrivals.given ? 0 : positions * (plan.options.planning.placement == Placement::path ? 12 : 1);
  return plan.input.known.size() + plan.arrivals.list.size() + 1 +
         static_cast<std::size_t>(std::min(placed, 1e9));
}

void check_known(const std::vector<State>& known) {
  for (const State& state : known)
    if (state.usable() && (!state.at.allFinite() || !state.force.allFinite()))
      throw InputError("states", "a known state is not finite, expected finite positions and forces");
}

// From the place at rest, or where the body is touched anywhere from the body [m].
double distance_from(const TouchedBody& touched, const Vec3& x) {
  if (!touched.anywhere) return x.norm();
  const Box body = touched.anywhere->surface->box();
  return (x - x.cwiseMax(body.low).cwiseMin(body.high)).norm();
}

// Refuses motions that go too far from rest, usually because their unit is not metres; their references would take
// forever. The error names the farthest position, because it shows the unit best.
void check_motion(const SessionPlan& plan) {
  const double most = farthest_place(*plan.input.touched.body);
  const InputPlace place{.key = "device",
                         .value = plan.input.parts.device ? "object" : to_text(plan.options.motion.device)};
  double greatest = 0;
  for (std::size_t k = 0; k < plan.frames; k += 10) {
    const double t = frame_time(k, plan.options.clock.frame);
    const double distance = distance_from(plan.input.touched, plan.device->position(t, Vec3::Zero()));
    if (!std::isfinite(distance))
      throw InputError(place, fmt::format("its position at {:g} s is not finite, expected metres", t));
    greatest = std::max(greatest, distance);
  }
  if (!(greatest <= most)) throw InputError(place, "leads to a position that " + too_far(greatest, most));
}

// Collects notes on a recorded motion: on its file, and on the part that the session uses.
void note_motion(SessionPlan& plan) {
  const auto* motion = std::get_if<TraceMotion>(&plan.options.motion.device.motion());
  if (!motion || plan.input.parts.device || plan.options.motion.replay) return;
  const std::filesystem::path file = found_from(plan.input.files.scene, motion->file);
  TraceRows rows = read_trace_rows(file, motion->format, MissingPositions::leave_out);
  for (Vec3& x : rows.positions) x = motion->scale * x + motion->offset;
  plan.motion_notes = trace_notes(rows);
  const TraceRows used = window(rows, 0, plan.options.clock.seconds);
  if (!plan.input.touched.anywhere)  // in the axes of the mesh there is no place of rest, and no box
    for (std::string& line : trace_warnings(check_trace(used, plan.input.touched.space.box)))
      plan.motion_notes.push_back(std::move(line));
  for (std::string& line : plan.motion_notes) line = fmt::format("trace {}: {}", motion->file.string(), line);
}

void take_replay(SessionPlan& plan) {
  Replay replay = read_replay(*plan.options.motion.replay, farthest_place(*plan.input.touched.body));
  if (plan.input.touched.anywhere && !replay.anywhere)
    throw InputError("replay",
                     "that run holds one place of the body, expected a scene without contact.anywhere");
  plan.device = make_trace_device(std::move(replay.motion));
  plan.arrivals.list = std::move(replay.arrivals);
  plan.arrivals.of_replay = replay.of_arrivals;
  plan.arrivals.given = true;
}

void take_device(SessionPlan& plan) {
  const TouchedBody& touched = plan.input.touched;
  const SessionOptions& options = plan.options;
  const bool of_path = std::holds_alternative<PathMotion>(options.motion.device.motion());
  if (of_path && !plan.input.parts.device && !(touched.space.box.size().maxCoeff() > 0))
    throw InputError("state_space.box", "is a point, expected room for a path");
  plan.device = plan.input.parts.device
                    ? plan.input.parts.device
                    : make_device(options.motion.device, factory_context(plan.input, options.seed));
  if (!options.planning.arrivals) return;
  const double farthest =
      touched.anywhere ? std::numeric_limits<double>::infinity() : farthest_place(*touched.body);
  plan.arrivals.list = read_arrivals(*options.planning.arrivals, farthest);
  plan.arrivals.given = true;
}

// Gives each arrival its place on the surface, where the body may be touched anywhere.
void place_arrivals(SessionPlan& plan) {
  for (Arrival& arrival : plan.arrivals.list) {
    if (!plan.input.touched.anywhere) {
      if (arrival.site.exists())
        throw InputError(plan.options.motion.replay ? "replay" : "arrivals",
                         "its states have sites, expected a scene with contact.anywhere");
      continue;
    }
    const SurfaceMap& map = plan.input.touched.anywhere->field->rest().map();
    const SurfacePlace nearest = map.nearest(arrival.site.exists() ? arrival.site.at : arrival.at);
    if (!arrival.site.exists()) arrival.at -= nearest.at, arrival.site.at = nearest.at;
    arrival.site.facet = nearest.facet;
    const double most = farthest_of(plan.input.touched.anywhere->depth);
    if (!(arrival.at.norm() <= most))
      throw InputError(
          "arrivals",
          fmt::format(
              "the state at {:g} s is {:.3g} m from its place on the surface, expected at most {:.3g} m",
              arrival.t, arrival.at.norm(), most));
  }
}

// Refuses a design that gives no candidates.
void check_design(const SessionPlan& plan) {
  const StateSpaceOptions& space = plan.input.touched.space;
  const bool read = !plan.arrivals.given && !plan.input.touched.anywhere &&
                    plan.options.planning.placement == Placement::lattice;
  if (read && space.design == Design::error) designed_places(space);
}

// Sets the plan up so that nothing is dispatched: as for states that arrive at given times, but none arrive.
void take_foreign(SessionPlan& plan) {
  if (!plan.input.foreign) return;
  if (!plan.arrivals.list.empty())
    throw InputError(
        "foreign",
        "states that arrive at given times (--arrivals, --replay) would be solved for the scene's "
        "body and mixed with those of another, expected a session without them");
  plan.arrivals.given = true;
  plan.input.files.states.reset();
}

// Checks registered parts that are made later, so that errors appear now.
void check_registered(const SessionPlan& plan) {
  const WorkerOptions& workers = plan.options.workers;
  const SessionParts& parts = plan.input.parts;
  const bool is_virtual = plan.options.clock.kind == Clock::virtual_time;
  predictor_of(plan.input, plan.options);
  const Box& box = plan.input.touched.space.box;
  if (is_virtual && parts.cost)
    coarse_costs(*parts.cost, box);
  else if (is_virtual && std::holds_alternative<Registered>(workers.cost.cost()))
    coarse_costs(*make_cost(workers.cost, factory_context(plan.input, plan.options.seed), {}), box);
  if (is_virtual ? !parts.virtual_workers : !parts.workers && !workers.ranks)
    check_workers(workers.kind, is_virtual);
}

// Length of the session, given the duration of the motion [s].
void settle_length(double duration, ClockOptions& clock) {
  if (!(duration >= 0))
    throw InputError("device",
                     fmt::format("its motion lasts {} s, expected at least 0 s, or infinity", duration));
  const double whole = duration + clock.frame;  // the last row is a frame of its own
  if (std::isfinite(duration) && clock.length == RunLength::motion) clock.seconds = whole;
  if (std::isfinite(duration) && clock.length == RunLength::shorter)
    clock.seconds = std::min(clock.seconds, whole);
  clock.length = RunLength::seconds;
  check(clock);
}

// Chooses the settings that depend on the known states.
void choose_model(SessionPlan& plan) {
  const SessionModelOptions& model = plan.options.model;
  const bool others_states = plan.input.foreign || plan.options.planning.arrivals ||
                             plan.arrivals.of_replay || std::ranges::any_of(plan.input.known, &State::usable);
  plan.model = {.fit = for_states(model.fit, most_states(plan)),
                .method = model.method,
                .update_travel = model.update_travel,
                .guess = Mat3::Zero()};
  plan.guess.softness = unknown;
  plan.guess.left_out.clear();
  if (!model.first_guess || others_states || plan.input.touched.anywhere) return;
  const FirstGuess guess = first_guess(plan.input.touched.body);
  plan.guess.softness = guess.softness;
  plan.guess.left_out = guess.left_out;
  plan.model.guess = guess.stiffness;
}

void take_future(SessionPlan& plan) {
  plan.motion.clear();
  const std::shared_ptr<Policy> policy = policy_of(plan.input, plan.options);
  if (!policy->reads_future()) return;
  if (plan.device->answers_force())
    throw InputError(
        "session.policy",
        fmt::format(
            "'{}' knows the motion beforehand, but that of device {} depends on the force; "
            "expected path:NAME or trace:FILE",
            plan.input.parts.policy ? std::string(policy->name()) : to_text(plan.options.planning.policy),
            to_text(plan.options.motion.device)));
  for (std::size_t k = 0; k < plan.frames; ++k)
    plan.motion.push_back(plan.device->position(frame_time(k, plan.options.clock.frame), Vec3::Zero()));
}

MemoryRequest memory_request(const SessionPlan& plan) {
  const WorkerOptions& workers = plan.options.workers;
  const bool threads = plan.options.clock.kind == Clock::real && !plan.arrivals.given &&
                       !plan.input.parts.workers && workers.kind.name == "threads";
  return {.body = plan.input.touched.body,
          .frames = plan.frames,
          .seconds = plan.options.clock.seconds,
          .workers = threads ? workers.count : 0,
          .threads = workers.threads,
          .jet = plan.input.touched.jet};
}

// A clairvoyant session is simulated several times with the same parts.
void check_reusable(const SessionParts& parts) {
  if (parts.predictor || parts.virtual_workers)
    throw InputError(
        "session.policy",
        "'clairvoyant' simulates the session several times, but a predictor or workers given as an "
        "object serve one session; register it under a name");
}

}  // namespace

namespace {

void check_anywhere(const TouchedBody& touched, const SessionOptions& options) {
  if (!touched.anywhere) return;
  if (options.switching.rule == SwitchRule::paper)
    throw InputError(
        "session.switch",
        "is paper, which needs two models in every frame, expected smooth or none with contact.anywhere");
  if (std::holds_alternative<RecordedCost>(options.workers.cost.cost()))
    throw InputError(
        "cost",
        "recorded times are of one place, expected constant, lognormal or paper with contact.anywhere");
}

}  // namespace

SessionPlan make_plan(SessionInput input, SessionOptions options) {
  detail::expect_option(input.touched.body != nullptr, "body", "there is none, expected a body to touch");
  if (!input.touched.anywhere) check(*input.touched.body, "the session's body");  // else by its field
  const std::string viscosity = problem_of(input.touched.viscosity);
  if (!viscosity.empty()) throw InputError("material.viscosity", "has " + viscosity);
  options.switching.frame = options.clock.frame;
  check(options);
  check_anywhere(input.touched, options);
  check_known(input.known);
  if (options.model.fit.data == Data::jet && input.touched.jet < 2) input.touched.jet = most_jet_order;
  SessionPlan plan{.input = std::move(input), .options = std::move(options), .device = nullptr};
  const SessionOptions& chosen = plan.options;
  if (chosen.motion.replay)
    take_replay(plan);
  else
    take_device(plan);
  place_arrivals(plan);
  take_foreign(plan);
  check_design(plan);
  settle_length(plan.device->duration(), plan.options.clock);
  plan.frames = static_cast<std::size_t>(std::llround(chosen.clock.seconds / chosen.clock.frame));
  detail::expect_option(plan.frames >= 1, "seconds", "is shorter than a frame");
  check_memory(memory_request(plan), available_memory());
  check_motion(plan);
  note_motion(plan);
  choose_model(plan);
  if (chosen.planning.batch == 0) plan.options.planning.batch = chosen.clock.kind == Clock::real ? 8 : 1;
  if (plan.input.touched.anywhere) plan.options.planning.batch = 1;  // a factorisation serves one site
  plan.render = {.switching = chosen.switching,
                 .safety = chosen.safety,
                 .frame = chosen.clock.frame,
                 .viscosity = plan.input.touched.viscosity};
  plan.render.safety.force_limit = std::min(chosen.safety.force_limit, plan.device->limits().force);
  plan.render.passivity = passivity_options(plan.render.safety, plan.device->limits(), chosen.clock.frame);
  take_future(plan);
  check_registered(plan);
  if (is_rehearsed(plan)) check_reusable(plan.input.parts);
  return plan;
}

SessionPlan with_known(SessionPlan plan, std::vector<State> known) {
  check_known(known);
  std::ranges::move(known, std::back_inserter(plan.input.known));
  choose_model(plan);
  return plan;
}

SessionPlan with_foreign(SessionPlan plan, std::vector<State> known) {
  plan.input.foreign = true;
  take_foreign(plan);
  return with_known(std::move(plan), std::move(known));
}

SessionPlan with_state_file(SessionPlan plan, std::filesystem::path file) {
  plan.input.files.states = std::move(file);
  return plan;
}

SessionPlan with_inputs_file(SessionPlan plan, std::filesystem::path file, std::string program) {
  plan.input.files.inputs = std::move(file);
  plan.input.files.program = std::move(program);
  return plan;
}

SessionPlan with_policy(SessionPlan plan, const PolicySpec& policy) {
  plan.options.planning.policy = policy;
  take_future(plan);
  return plan;
}

}  // namespace forefeel
