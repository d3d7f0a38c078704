#include "scheduling/touch/touch_session.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <thread>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/states/state_file.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/render/frame_pacer.hpp"
#include "scheduling/render/loop_thread.hpp"
#include "scheduling/session/passivity_plan.hpp"
#include "scheduling/session/rehearsal.hpp"
#include "scheduling/touch/touch_judge.hpp"
#include "scheduling/touch/touch_loop.hpp"
#include "scheduling/touch/touch_ranks.hpp"
#include "scheduling/touch/touch_workers.hpp"
#include "scheduling/workers/cost.hpp"

namespace forefeel {
namespace {

// Where the site moved far while the tip hardly did: the body snapped under it, or E has another valley beyond.
std::string jumps_in_words(std::span<const TouchFrameRecord> frames) {
  constexpr double far = 0.002, times = 10;  // [m], and over the way of the tip
  std::size_t jumps = 0;
  double farthest = 0;
  for (std::size_t k = 1; k < frames.size(); ++k) {
    const TouchFrameRecord &now = frames[k], &before = frames[k - 1];
    if (now.touch == TouchKind::none || before.touch == TouchKind::none) continue;
    const double way = (now.site.at - before.site.at).norm();
    if (way < far + times * (now.tip - before.tip).norm()) continue;
    ++jumps, farthest = std::max(farthest, way);
  }
  if (jumps == 0) return {};
  return fmt::format(
      "the site jumped in {} frames, by up to {:.1f} mm: the body snaps under the tip there, or the model is "
      "wrong",
      jumps, 1e3 * farthest);
}

using Show = std::function<void(const TouchProgress&)>;

// Everything of one run but the workers.
struct Parts {
  const TouchSessionInput& input;
  const SessionOptions& options;
  SessionSurface surface;
  FactoryContext context;
  std::unique_ptr<Device> device;
  std::unique_ptr<CostModel> cost;
  TouchLink link = {};
  FieldOfSites field;
  TouchPlanner planner;
  std::size_t frames = 0;
  TouchLoop loop;
  std::unique_ptr<StateWriter> file;
  std::string file_failure = {};

  std::int64_t started = 0;  // of the real clock [ns]

  Parts(const TouchSessionInput& given, const SessionOptions& chosen)
      : input(given),
        options(chosen),
        surface(given.task.field->rest(), *given.task.grid, given.task.depth, given.draw),
        context{.box = surface.box(), .seed = chosen.seed, .folder = given.folder, .surface = &surface},
        device(make_device(chosen.motion.device, context)),
        cost(make_cost(chosen.workers.cost, context, [] { return refuse_recorded(); })),
        field(given.task.field, given.task.grid, farthest_of(given.task.depth), given.task.patches),
        planner(given.task, planner_parts(), given.known),
        frames(frames_of()),
        loop(*device, field, link, loop_options(), frames, wall_clock()) {
    link.models.publish(planner.model());
    if (given.states.empty()) return;
    StateFileHeader header;
    header.identity = given.identity;
    header.spacing = given.task.tips.spacing;
    header.box = given.task.tips.box;
    file = std::make_unique<StateWriter>(StateFile::open_or_create(given.states, header));
  }

  std::function<double()> wall_clock() const {
    if (options.clock.kind != Clock::real) return {};
    return [this] { return static_cast<double>(monotonic() - started) / 1e9; };
  }

  static RecordedCosts refuse_recorded() {
    throw InputError(
        "cost",
        "recorded times are of one place, expected constant, lognormal or paper with contact.anywhere");
  }

  TouchPlannerParts planner_parts() const {
    FactoryContext with = context;
    TouchPlannerParts parts{.policy = make_policy(options.planning.policy, with),
                            .predictor = make_predictor(options.motion.predictor, with),
                            .workers = options.workers.count,
                            .solve_seconds = checked_seconds(*cost, Vec3::Zero())};
    if (!parts.policy->reads_future()) return parts;
    std::vector<Vec3> motion;
    for (std::size_t k = 0; k < frames_of(); ++k)
      motion.push_back(device->position(frame_time(k, options.clock.frame), Vec3::Zero()));
    parts.future = [motion = std::move(motion), frame = options.clock.frame](double t) {
      const double k = std::clamp(std::round(t / frame), 0.0, static_cast<double>(motion.size() - 1));
      return motion[static_cast<std::size_t>(k)];
    };
    return parts;
  }

  std::size_t frames_of() const {
    double seconds = options.clock.seconds;
    const double motion = device->duration();
    if (options.clock.length == RunLength::motion && std::isfinite(motion)) seconds = motion;
    if (options.clock.length == RunLength::shorter) seconds = std::min(seconds, motion);
    return static_cast<std::size_t>(std::max(1.0, std::ceil(seconds / options.clock.frame - 1e-9)));
  }

  TouchLoopOptions loop_options() const {
    TouchLoopOptions loop_options;
    loop_options.render.switching = options.switching;
    loop_options.render.switching.frame = options.clock.frame;
    loop_options.render.safety = options.safety;
    loop_options.render.safety.force_limit = std::min(options.safety.force_limit, device->limits().force);
    loop_options.render.frame = options.clock.frame;
    loop_options.render.viscosity = input.viscosity;
    loop_options.render.passivity = passivity_options(options.safety, device->limits(), options.clock.frame);
    loop_options.friction = input.task.friction;
    return loop_options;
  }

  // A job's end. Returns whether there is something new to render.
  bool take(TouchDone done, double now) {
    const State state = done.solved.state;
    const bool is_new = planner.receive(done.id, std::move(done.solved), done.started, done.finished, now);
    if (file && state.solve.status != SolveStatus::cancelled) try {
        file->push(state);
      } catch (const std::exception& problem) {
        file_failure = fmt::format("{}; states that were solved later are not in this file", problem.what());
        file.reset();
      }
    return is_new;
  }

  void finish(TouchSessionResult& result) {
    if (file) try {
        file->flush();
      } catch (const std::exception& problem) {
        file_failure = problem.what();
      }
    if (!file_failure.empty()) result.notes.push_back(file_failure);
    result.frames = loop.take_log();
    if (std::ranges::none_of(result.frames, [](const auto& f) { return f.touch != TouchKind::none; }))
      result.notes.push_back("the tip never entered the body");
    if (loop.unfelt() > 0)
      result.notes.push_back(
          fmt::format("in {} frames the tip was inside the body and felt nothing: it had come "
                      "through the clamp, or a touch had ended there under tension",
                      loop.unfelt()));
    if (const std::string line = jumps_in_words(result.frames); !line.empty()) result.notes.push_back(line);
    result.dispatches = planner.dispatches();
    result.states = planner.known();
    result.models = planner.models();
    result.failed = planner.failed();
    const Safety& safety = loop.safety();
    result.safety.clamped = safety.counts().clamped, result.safety.slewed = safety.counts().slewed;
    result.safety.stale = safety.counts().stale, result.safety.non_finite = safety.counts().non_finite;
    result.safety.generated = safety.generated(), result.safety.work = safety.work();
    result.safety.passivity = loop.passivity(), result.safety.uncontrolled = loop.take_uncontrolled();
    result.loop.ending_frames = safety.counts().ending;
    result.loop.device_held = loop.faults().held, result.loop.device_jumps = loop.faults().jumps;
  }
};

constexpr double plan_every = 0.010;  // where nothing has changed [s]

void run_virtual(Parts& parts, TouchSessionResult& result, const Show& show) {
  VirtualTouchWorkers workers(parts.input.task.field->rest_shared(), parts.input.task.tips.spacing,
                              parts.options.workers.count);
  const double frame = parts.options.clock.frame, latency = parts.options.workers.latency;
  double planned = -1;
  for (std::size_t k = 0; !parts.loop.finished(); ++k) {
    const double now = frame_time(k, frame);
    bool came = false, changed = false;
    for (TouchDone& done : workers.done(now - latency))
      changed |= parts.take(std::move(done), now), came = true;
    if (changed) parts.link.models.publish(parts.planner.model());
    parts.link.planner_beat.store(now, std::memory_order_relaxed);
    if (parts.options.stop.is_interrupted()) parts.loop.end(), result.interrupted = true;
    parts.loop.frame(k, now);
    if (const auto seen = parts.link.seen.take()) parts.planner.observe(*seen);
    if (!came && now - planned < plan_every) continue;
    planned = now;
    if (parts.options.planning.preempt && workers.idle().empty())
      if (const auto worker = parts.planner.preempted(now)) workers.cancel(*worker, now);
    for (TouchJob& job : parts.planner.plan(workers.idle(), now)) {
      const double seconds = job.x.isZero(0) ? checked_rest_seconds(*parts.cost)
                                             : checked_seconds(*parts.cost, job.site.at + job.x);
      const int worker = parts.planner.dispatches()[job.id].worker;
      workers.dispatch(worker, std::move(job), now + latency, seconds);
    }
    if (show && k % 250 == 0)
      show({.done = now,
            .whole = static_cast<double>(parts.frames) * frame,
            .known = parts.planner.known().size()});
  }
}

struct LoopThread {
  Parts& parts;
  FramePacer pacer;
  std::int64_t start = 0;
  std::atomic<bool> done{false};
  std::string note = {};

  void run(const StopOptions& stop) {
    const std::string refused = become_loop_thread();
    if (!refused.empty()) note = "the loop runs without real-time priority: " + refused;
    while (!parts.loop.finished()) {
      sleep_until(start + pacer.due());
      const std::int64_t woke = monotonic();
      const std::size_t k = pacer.begin(woke - start);
      if (stop.is_interrupted()) parts.loop.end();
      parts.loop.frame(k, static_cast<double>(woke - start) / 1e9);
      parts.loop.note_timing(static_cast<double>(monotonic() - woke) / 1e3,
                             static_cast<double>(pacer.lateness()) / 1e3);
    }
    done.store(true, std::memory_order_release);
  }
};

void run_real(Parts& parts, TouchSessionResult& result, const Show& show) {
  const std::int64_t start = parts.started = monotonic();
  LoopThread loop{parts, FramePacer(parts.options.clock.frame, parts.frames), start};
  const auto now = [start] { return static_cast<double>(monotonic() - start) / 1e9; };
  const std::unique_ptr<TouchWorkers> workers =
      parts.input.ranks ? make_touch_ranks(*parts.input.ranks, now)
                        : std::make_unique<RealTouchWorkers>(parts.input.task.field->rest_shared(),
                                                             parts.input.task.tips.spacing,
                                                             parts.options.workers.count, now);
  std::jthread thread([&] { loop.run(parts.options.stop); });
  double planned = -1, shown = 0;
  while (!loop.done.load(std::memory_order_acquire)) {
    bool came = false, changed = false;
    for (TouchDone& done : workers->done(0.0005)) changed |= parts.take(std::move(done), now()), came = true;
    if (changed) parts.link.models.publish(parts.planner.model());
    if (const auto seen = parts.link.seen.take()) parts.planner.observe(*seen);
    parts.link.planner_beat.store(now(), std::memory_order_relaxed);
    if (came || now() - planned >= plan_every) {
      planned = now();
      if (parts.options.planning.preempt && workers->idle().empty())
        if (const auto worker = parts.planner.preempted(planned)) workers->cancel(*worker);
      for (TouchJob& job : parts.planner.plan(workers->idle(), planned)) {
        const int worker = parts.planner.dispatches()[job.id].worker;
        workers->dispatch(worker, std::move(job));
      }
    }
    if (show && now() - shown > 0.25) {
      shown = now();
      show({.done = shown,
            .whole = static_cast<double>(parts.frames) * parts.options.clock.frame,
            .known = parts.planner.known().size()});
    }
  }
  thread.join();
  result.interrupted = parts.options.stop.is_interrupted();
  result.loop.skipped = loop.pacer.skipped();
  result.loop.longest_pause = loop.pacer.longest_pause(), result.loop.paused_at = loop.pacer.paused_at();
  if (!loop.note.empty()) result.notes.push_back(loop.note);
  for (std::string& note : workers->notes()) result.notes.push_back(std::move(note));
  if (loop.pacer.skipped() > 0)
    result.notes.push_back(fmt::format("{} of {} frames came a frame or more late and were skipped",
                                       loop.pacer.skipped(), parts.frames));
}

}  // namespace

void check_touch_session(const TouchSessionInput& input, const SessionOptions& options) {
  if (options.switching.rule == SwitchRule::paper)
    throw InputError(
        "session.switch",
        "is paper, which needs two models in every frame, expected smooth or none with contact.anywhere");
  if (options.workers.count < 1) throw InputError("session.workers", "is 0, expected at least one");
  const SessionSurface surface(input.task.field->rest(), *input.task.grid, input.task.depth, input.draw);
  const FactoryContext context{
      .box = surface.box(), .seed = options.seed, .folder = input.folder, .surface = &surface};
  const std::unique_ptr<Device> device = make_device(options.motion.device, context);
  FactoryContext with = context;
  if (make_policy(options.planning.policy, with)->reads_future() && device->answers_force())
    throw InputError(
        "session.policy",
        fmt::format("'{}' knows the motion beforehand, but that of device {} depends on the force; "
                    "expected path:NAME or trace:FILE",
                    options.planning.policy.name, to_text(options.motion.device)));
  make_predictor(options.motion.predictor, context);
  passivity_options(options.safety, device->limits(), options.clock.frame);
}

namespace {

TouchSessionResult run_and_judge(const TouchSessionInput& input, const SessionOptions& options,
                                 const Show& progress) {
  TouchSessionResult result;
  {
    Parts parts(input, options);
    result.known_at_start = parts.planner.known().size();
    if (options.clock.kind == Clock::real)
      run_real(parts, result, progress);
    else
      run_virtual(parts, result, progress);
    parts.finish(result);
  }
  judge(input,
        {.judging = options.judging,
         .jnd = options.switching,
         .stop = options.stop,
         .threads = options.workers.threads > 0 ? options.workers.threads : omp_get_max_threads(),
         .progress = progress},
        result);
  return result;
}

// Share of first visits within the JND; negative without any.
double visits_within(const TouchSessionResult& result, const SwitchOptions& jnd) {
  std::size_t visits = 0, within = 0;
  for (const TouchFrameRecord& f : result.frames) {
    if (!f.judged.first_visit || !std::isfinite(f.judged.error)) continue;
    ++visits, within += is_within_jnd(f, jnd);
  }
  return visits > 0 ? static_cast<double>(within) / static_cast<double>(visits) : -1.0;
}

// Runs the best of all schedules (scheduling/session/rehearsal.hpp).
TouchSessionResult rehearse_and_run(const TouchSessionInput& input, SessionOptions options,
                                    const Show& progress) {
  const std::vector<std::string> schedules = schedules_to_rehearse();
  TouchSessionInput trial = input;
  trial.states.clear();
  std::string best = schedules.front();
  double most = -2;
  std::size_t tried = 0;
  for (; tried < schedules.size() && most < 1; ++tried) {
    options.planning.policy = PolicySpec(schedules[tried]);
    const Show shown = [&](TouchProgress p) {
      p.rehearsal = tried + 1, p.rehearsals = schedules.size();
      if (progress) progress(p);
    };
    TouchSessionResult result = run_and_judge(trial, options, shown);
    if (options.stop.is_interrupted()) {
      result.notes.push_back(fmt::format("interrupted while simulating schedule {} of {}: this is its run",
                                         tried + 1, schedules.size()));
      return result;
    }
    if (const double share = visits_within(result, options.switching); share > most)
      most = share, best = schedules[tried];
  }
  options.planning.policy = PolicySpec(best);
  TouchSessionResult result = run_and_judge(input, options, progress);
  result.notes.push_back(
      fmt::format("clairvoyant: {} was the best of {} schedules that were simulated{}", best, tried,
                  most >= 1 ? ": all first visits are within the JND, none can be better" : ""));
  return result;
}

}  // namespace

TouchSessionResult run_touch_session(const TouchSessionInput& input, const SessionOptions& options,
                                     const Show& progress) {
  check_touch_session(input, options);
  if (options.planning.policy.name == "clairvoyant" && options.clock.kind == Clock::virtual_time)
    return rehearse_and_run(input, options, progress);
  return run_and_judge(input, options, progress);
}

}  // namespace forefeel
