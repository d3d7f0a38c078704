#include "scheduling/session/session.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "approx/model/model_options.hpp"
#include "geometry/common/csv_table.hpp"
#include "geometry/common/error.hpp"
#include "geometry/index/lattice_room.hpp"
#include "scheduling/policy/candidates.hpp"
#include "scheduling/render/session_model.hpp"
#include "scheduling/session/session_parts.hpp"
#include "solver/body/contact_stiffness.hpp"

namespace forefeel {
namespace {

void expect(bool holds, const char* key, const std::string& problem) {
  if (!holds) throw InputError(std::string("session.") + key, problem);
}

template <class T>
bool positive(T value) {
  return std::isfinite(static_cast<double>(value)) && value > 0;
}

void check(const SessionInput& input, const SessionOptions& o) {
  expect(input.body != nullptr, "body", "there is none, expected a body to touch");
  expect(positive(o.seconds) && o.seconds <= 86400, "seconds",
         fmt::format("is {}, expected more than 0 and at most 86400", o.seconds));
  expect(o.workers >= 1 && o.workers <= 100000, "workers",
         fmt::format("is {}, expected 1 to 100000", o.workers));
  expect(o.batch >= 0 && o.batch <= 8, "batch",
         fmt::format("is {}, expected 0 (by the clock) to 8 states", o.batch));
  expect(positive(o.batch_share) && o.batch_share <= 1, "batch_share",
         fmt::format("is {}, expected a share above 0, at most 1", o.batch_share));
  expect(o.threads >= 0, "threads", fmt::format("is {}, expected 0 (all) or more", o.threads));
  expect(positive(o.frame) && o.frame <= 0.1, "frame",
         fmt::format("is {}, expected a frame time above 0 and at most 0.1 s", o.frame));
  expect(o.latency >= 0 && o.latency <= 86400, "latency",
         fmt::format("is {}, expected 0 to 86400 s", o.latency));
  expect(positive(o.update_travel), "update_travel",
         fmt::format("is {}, expected spacings above 0", o.update_travel));
  expect(positive(o.error_floor), "error_floor",
         fmt::format("is {}, expected a force above 0 N", o.error_floor));
  expect(positive(o.reference_step), "reference_step",
         fmt::format("is {}, expected a length above 0 m", o.reference_step));
  expect(o.visit_cell == 0 || (positive(o.visit_cell) && o.visit_cell >= 1e-9), "visit_cell",
         fmt::format("is {}, expected 0 (the spacing) or a length of at least 1e-9 m", o.visit_cell));
  expect(o.visit_stride >= 1, "visit_stride",
         fmt::format("is {}, expected 1 (every first visit) or more", o.visit_stride));
  expect(positive(o.force_limit), "force_limit",
         fmt::format("is {}, expected a force above 0 N", o.force_limit));
  expect(positive(o.slew_limit), "slew_limit", fmt::format("is {}, expected N/s above 0", o.slew_limit));
  expect(std::isfinite(o.ramp_seconds) && o.ramp_seconds >= 0, "ramp_seconds",
         fmt::format("is {}, expected 0 s or more", o.ramp_seconds));
  expect(positive(o.stale_seconds), "stale_seconds",
         fmt::format("is {}, expected a time above 0 s", o.stale_seconds));
  expect(positive(o.seconds / o.frame) && o.seconds / o.frame < 1e8, "seconds",
         "and frame give too many frames");
  expect(!(o.arrivals && o.replay), "arrivals", "cannot go with replay, which brings its own");
}

// Farther from rest nothing of the body can be [m].
double farthest(const Body& body) {
  return 2 * bounding_box(body.mesh).size().maxCoeff();
}

// As many states as there can be in the session, or a few more: `path` places states half a spacing apart, of which no more
// than 12 go into the room of a lattice state.
std::size_t most_states(const SessionPlan& plan) {
  const StateSpaceOptions& space = plan.input.space;
  const double positions = ((space.box.size() / space.spacing).array().floor() + 2).prod();
  const double placed =
      plan.given_arrivals ? 0
                          : positions * (check_placement(plan.options.placement) == Placement::path ? 12 : 1);
  return plan.input.known.size() + plan.arrivals.size() + 1 + static_cast<std::size_t>(std::min(placed, 1e9));
}

void check_near(const Vec3& at, double farthest, const std::filesystem::path& file, std::size_t line) {
  if (!(at.norm() <= farthest))
    throw InputError(
        {.file = file.string(), .line = line},
        fmt::format("is {:.4g} m from rest, expected metres, at most {:.4g} (twice the body's length)",
                    at.norm(), farthest));
}

// A motion in other units than metres leads where no body can be pulled, and its references would take for ever.
void check_motion(const SessionPlan& plan) {
  const double most = farthest(*plan.input.body);
  for (std::size_t k = 0; k < plan.frames; k += 10) {
    const double distance = plan.device->position(frame_time(k, plan.options.frame), Vec3::Zero()).norm();
    if (!(distance <= most))
      throw InputError(
          {.key = "device", .value = plan.options.device},
          fmt::format("leads {:.4g} m from rest, expected metres, at most {:.4g} (twice the body's length)",
                      distance, most));
  }
}

SessionPlan make_plan(const SessionInput& input, const SessionOptions& options) {
  check(input, options);
  make_policy(options.policy, {.seed = options.seed});  // unknown names are refused before anything runs
  make_predictor(options.predictor);
  check_method(options.method);
  check_placement(options.placement);
  check_cost(options.cost);
  SessionPlan plan(input, options);
  bool replay_of_arrivals = false;
  if (options.replay) {
    Replay replay = read_replay(*options.replay, farthest(*input.body));
    plan.device = make_trace_device(std::move(replay.motion.times), std::move(replay.motion.positions));
    plan.arrivals = std::move(replay.arrivals);
    replay_of_arrivals = replay.of_arrivals;
    plan.given_arrivals = true;
  } else {
    if (options.device.starts_with("path:") && !(input.space.box.size().maxCoeff() > 0))
      throw InputError("state_space.box", "is a point, expected room for a path");
    plan.device = make_device(
        options.device,
        {.box = input.space.box, .inward = input.inward, .seed = options.seed, .folder = input.scene_folder});
    if (options.arrivals) {
      plan.arrivals = read_arrivals(*options.arrivals, farthest(*input.body));
      plan.given_arrivals = true;
    }
  }
  plan.frames = static_cast<std::size_t>(std::llround(options.seconds / options.frame));
  expect(plan.frames >= 1, "seconds", "is shorter than a frame");
  check_motion(plan);
  const bool others_states =
      options.arrivals || std::ranges::any_of(input.known, &State::usable) || replay_of_arrivals;
  plan.options.guess =
      options.first_guess && !others_states ? disc_stiffness(*input.body) : Mat3(Mat3::Zero());
  plan.options.model = for_states(options.model, most_states(plan));
  if (options.batch == 0) plan.options.batch = options.clock == Clock::real ? 8 : 1;
  plan.options.force_limit = std::min(options.force_limit, plan.device->limits().force);
  if (knows_the_future(options.policy) && plan.device->answers_force())
    throw InputError(
        "session.policy",
        fmt::format("'{}' knows the motion beforehand, but that of device {} depends on the force; "
                    "expected path:NAME or trace:FILE",
                    options.policy, options.device));
  if (knows_the_future(options.policy))
    for (std::size_t k = 0; k < plan.frames; ++k)
      plan.motion.push_back(plan.device->position(frame_time(k, options.frame), Vec3::Zero()));
  return plan;
}

void check_known(const SessionInput& input) {
  for (const State& state : input.known)
    if (state.usable() && (!state.at.allFinite() || !state.force.allFinite()))
      throw InputError("states", "a known state is not finite, expected finite positions and forces");
}

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
  const Box& box = plan.input.space.box;
  const double side = plan.options.visit_cell > 0 ? plan.options.visit_cell : plan.input.space.spacing;
  const Eigen::Array3d low = (box.low / side).array() - 1e-9, high = (box.high / side).array() + 1e-9;
  std::string solved;
  if (!plan.given_arrivals && result.solve_seconds.empty() && !result.not_begun) {
    const bool none = !holds_lattice_position(box, plan.input.space.spacing);
    if (result.start_solved_failed[1] > 0)
      solved = "nothing but rest was solved: there is no load";
    else
      solved = none ? fmt::format(
                          "the box holds no position of the lattice of {:g} m: nothing could be solved, and "
                          "there is no load",
                          plan.input.space.spacing)
                    : "nothing was solved: there is no load";
  }
  if (((high.floor() - low.ceil()) < 1).any())
    result.notes.push_back(
        fmt::format("no cell of a lattice of {:g} m fits the box: there are no first visits{}{}", side,
                    solved.empty() ? "" : "; ", solved));
  else if (!holds_lattice_position(box, plan.input.space.spacing) && !solved.empty())
    result.notes.push_back(solved);
}

}  // namespace

std::vector<Arrival> read_arrivals(const std::filesystem::path& file, double farthest) {
  constexpr std::string_view columns[] = {"t", "x", "y", "z"};
  const CsvTable table = read_csv(file, columns);
  std::vector<Arrival> arrivals;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (table.at(i, 0) < 0)
      throw InputError({.file = file.string(), .line = table.lines[i]},
                       "t is negative, expected seconds from the start");
    if (table.at(i, 0) > 86400)
      throw InputError({.file = file.string(), .line = table.lines[i]},
                       fmt::format("t is {} s, expected at most 86400, a day", table.at(i, 0)));
    const Vec3 at(table.at(i, 1), table.at(i, 2), table.at(i, 3));
    check_near(at, farthest, file, table.lines[i]);
    arrivals.push_back({table.at(i, 0), at});
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.t < b.t; });
  return arrivals;
}

Replay read_replay(const std::filesystem::path& run_folder, double farthest) {
  Replay replay{.motion = read_trace(run_folder / "frames.csv"), .arrivals = {}, .of_arrivals = false};
  const auto dispatch = run_folder / "dispatch.csv";
  constexpr std::string_view columns[] = {"x", "y", "z", "finished", "known"};
  CsvTable table;
  try {
    table = read_csv(dispatch, columns, {.allow_empty_cells = true, .text_column = "status"});
  } catch (const InputError&) {
    if (!std::filesystem::exists(dispatch)) throw;
    return replay;  // a run in which nothing was dispatched
  }
  for (std::size_t i = 0; i < table.rows(); ++i)
    if (table.texts[i] == "solved" || table.texts[i] == "arrived") {
      replay.of_arrivals = replay.of_arrivals || table.texts[i] == "arrived";
      replay.arrivals.push_back({table.at(i, 4), Vec3(table.at(i, 0), table.at(i, 1), table.at(i, 2))});
      check_near(replay.arrivals.back().at, farthest, dispatch, table.lines[i]);
    }
  std::stable_sort(replay.arrivals.begin(), replay.arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.t < b.t; });
  return replay;
}

Planner::Hooks hooks_of(const SessionPlan& plan, StateWriter* writer) {
  Planner::Hooks hooks;
  if (writer) hooks.on_state = [writer](const State& state) { writer->push(state); };
  if (!plan.motion.empty())
    hooks.future = [&motion = plan.motion, frame = plan.options.frame](double t) {
      const auto k = static_cast<std::size_t>(std::max(0LL, std::llround(t / frame)));
      return motion[std::min(k, motion.size() - 1)];
    };
  if (plan.cost) {  // a body that has been solved before: its median is known
    std::vector<double> seconds;
    for (const Vec3& x : lattice(plan.input.space.box, plan.input.space.box.size().maxCoeff() / 4))
      seconds.push_back(plan.cost->seconds(x));
    std::ranges::nth_element(seconds, seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2));
    if (!seconds.empty()) hooks.expected_solve = seconds[seconds.size() / 2];
  }
  return hooks;
}

void take_loop(RenderLoop& loop, std::size_t frames, SessionResult& result) {
  result.frames = loop.take_log();
  result.interrupted = result.frames.size() < frames;
  if (result.interrupted)
    result.notes.push_back(fmt::format("interrupted after {} of {} frames", result.frames.size(), frames));
  const SafetyCounts& counts = loop.safety().counts();
  result.clamped = counts.clamped;
  result.slewed = counts.slewed;
  result.stale = counts.stale;
  result.non_finite = counts.non_finite;
  if (result.clamped > 0)
    result.notes.push_back(fmt::format(
        "{} of {} frames were clamped by safety: the device got less force than was rendered; the error is "
        "that of the rendered force",
        result.clamped, result.frames.size()));
  result.generated_energy = loop.safety().generated();
  result.work = loop.safety().work();
}

ReferenceOptions reference_options(const SessionInput& input) {
  return {.body = input.body,
          .identity = input.identity,
          .spacing = input.space.spacing,
          .box = input.space.box,
          .displacements = input.displacements,
          .cache_folder = input.cache_folder};
}

void check_session(const SessionInput& input, const SessionOptions& options) {
  make_plan(input, options);
  check_known(input);
}

double motion_seconds(const SessionInput& input, const SessionOptions& options) {
  return make_plan(input, options).device->duration();
}

namespace {

// Share of first visits within the JND; less than none where there are none.
double first_visits_within(const SessionResult& result, const SwitchOptions& jnd) {
  std::size_t visits = 0, within = 0;
  for (const FrameRecord& f : result.frames) {
    if (!f.first_visit || !std::isfinite(f.error)) continue;
    ++visits;
    within += (f.force - f.reference).norm() <= std::max(jnd.jnd_share * f.reference.norm(), jnd.jnd_floor);
  }
  return visits > 0 ? static_cast<double>(within) / static_cast<double>(visits) : -1.0;
}

// What an interrupted rehearsal leaves of the session: nothing was rendered, nothing solved that counts.
SessionResult not_begun(const SessionInput& input, std::string note) {
  if (input.state_file)
    StateFile::open_or_create(
        *input.state_file,
        {.identity = input.identity, .spacing = input.space.spacing, .box = input.space.box, .notes = {}});
  SessionResult result;
  StateSpace space(input.space);
  for (const State& state : input.known)
    if (state.usable() && space.insert(state).is_new) result.states.push_back(state);
  result.start_solved_failed[0] = result.states.size();
  result.interrupted = result.not_begun = true;
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
  if (own) input.references = std::make_shared<ReferenceService>(reference_options(input), options.threads);
  const auto state_file = std::exchange(input.state_file, std::nullopt);
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
    options.policy = name;
    ShowProgress rehearsal;
    if (show)
      rehearsal = [&](SessionProgress p) {
        p.phase = fmt::format("rehearsal {} of {}, {}", i + 1, schedules.size(), p.phase);
        show(p);
      };
    const SessionResult tried = run_session(input, options, rehearsal);
    if (options.interrupted && options.interrupted->load(std::memory_order_relaxed)) {
      input.state_file = state_file;
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
  options.policy = best;
  input.state_file = state_file;
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
  check_known(given);
  if (options.policy == "clairvoyant" && options.clock == Clock::virtual_time && !options.arrivals &&
      !options.replay) {
    make_plan(given, options);  // what cannot be run is refused under its own name
    return run_rehearsed(given, options, show, when_run, each_position);
  }
  const std::shared_ptr<ReferenceService> shared =
      given.references ? given.references
                       : std::make_shared<ReferenceService>(reference_options(given), options.threads);
  ReferenceService& references = *shared;
  SessionInput input = given;
  if (options.rest_known &&
      std::ranges::none_of(given.known, [](const State& s) { return s.usable() && s.at.isZero(0); }))
    input.known.push_back(references.get(Vec3::Zero()));
  SessionPlan plan = make_plan(input, options);
  if (options.clock == Clock::virtual_time)
    plan.cost = make_cost(options.cost, options.seed, [&] { return references.recorded_costs(); });
  SessionResult result;
  if (options.clock == Clock::real && (options.cost != SessionOptions{}.cost || options.latency > 0))
    result.notes.push_back("cost and latency are those of simulated workers: ignored under the real clock");
  if (references.note()) result.notes.push_back(*references.note());
  if (references.damage() && !given.references) result.warnings.push_back(*references.damage());
  const auto start = std::chrono::steady_clock::now();
  RunAnalysis analysis(input, plan.options, references, each_position);
  if (options.clock == Clock::virtual_time)
    run_virtual(plan, references, analysis, result, show);
  else
    run_real(plan, references, result, show);
  if (when_run) when_run(result);
  note_stiffness(plan.device->limits(), options.device, result);
  analysis.finish(result, show);
  note_no_cells(plan, result);
  result.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace forefeel
