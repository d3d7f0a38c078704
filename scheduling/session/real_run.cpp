#include "scheduling/session/real_run.hpp"

#include <fmt/format.h>
#include <omp.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <exception>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>

#include "geometry/common/counted.hpp"
#include "scheduling/render/input_log.hpp"
#include "scheduling/render/loop_thread.hpp"
#include "scheduling/render/model_keeper.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/session/run_parts.hpp"
#include "scheduling/session/session_setup.hpp"
#include "scheduling/shape/shape_thread.hpp"
#include "scheduling/touch/surface_models.hpp"
#include "scheduling/workers/rank_workers.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {
namespace {

using Nanoseconds = std::int64_t;

Nanoseconds wall_clock() {
  timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  return Nanoseconds{now.tv_sec} * 1000000000 + now.tv_nsec;
}

// Locks pages in memory during a session; a note reports if the system does not permit it. Pages are locked when they
// are first touched, because locking whole mappings would make the stacks of all threads resident, 8 MB for each
// worker. The data of the loop are touched before it begins.
class LockedMemory {
 public:
  explicit LockedMemory(SessionResult& result) {
    // With a limit on locked memory, later allocations would fail once it is reached. So only present pages are locked.
    rlimit limit{};
    const bool unlimited =
        geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
    const int what = unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT;
    locked_ = mlockall(what | MCL_ONFAULT) == 0 || (errno == EINVAL && mlockall(what) == 0);  // older kernels
    if (!locked_) result.notes.push_back(fmt::format("memory is not locked: {}", std::strerror(errno)));
    result.run.memory_locked = locked_;
  }
  ~LockedMemory() {
    if (locked_) munlockall();
  }
  LockedMemory(const LockedMemory&) = delete;
  LockedMemory& operator=(const LockedMemory&) = delete;

 private:
  bool locked_ = false;
};

// Messages between the loop's thread and the planner's, and the loop's report when it ends.
struct LoopEnd {
  std::atomic<bool> done{false};
  std::atomic<bool> wanted{false};  // by a failing planner
  bool realtime = false;
  std::string note;
};

void run_loop(RenderLoop& loop, FramePacer& pacer, const StopOptions& stop, Nanoseconds start, LoopEnd& end) {
  const std::string refused = become_loop_thread();
  end.realtime = refused.empty();
  if (!refused.empty()) end.note = "the loop runs without real-time priority: " + refused;
  while (!loop.finished()) {
    sleep_until(start + pacer.due());
    const Nanoseconds woke = monotonic();
    const std::size_t k = pacer.begin(woke - start);
    if (stop.is_interrupted() || end.wanted.load(std::memory_order_acquire)) loop.end();
    loop.frame(k, static_cast<double>(woke - start) / 1e9);
    loop.note_timing(static_cast<double>(monotonic() - woke) / 1e3,
                     static_cast<double>(pacer.lateness()) / 1e3);
  }
  end.done.store(true, std::memory_order_release);
}

// Of the planner's steps.
struct PlannerTimes {
  double stall = 0, beat = 0;  // longest time between two of them; end of the last one [s]
  std::size_t stalls = 0;      // times longer than the watchdog allows
  ClockWatch clock;

  void step(double t, double patience) {
    const double gap = t > 0 ? t - std::max(beat, 0.0) : 0;  // the session begins at 0
    stall = std::max(stall, gap);
    stalls += gap > patience ? 1 : 0;
    beat = t;
    clock.look(monotonic(), wall_clock());
  }
};

// How the loop and the planner kept time. stale: of the watchdog [s].
void report(const FramePacer& pacer, const PlannerTimes& planner, std::size_t frames, double stale,
            SessionResult& result) {
  const double stall = planner.stall;
  result.loop.skipped = pacer.skipped();
  result.loop.longest_pause = pacer.longest_pause();
  result.loop.paused_at = pacer.paused_at();
  result.loop.planner_stall = stall;
  result.loop.planner_stalls = planner.stalls;
  result.loop.clock_steps = planner.clock.steps();
  if (pacer.skipped() > 0)
    result.notes.push_back(
        fmt::format("{} of {} a frame or more late and skipped; the longest pause was {:.3g} s, at "
                    "{:.3f} s",
                    pacer.skipped(), counted(frames, "frame was", "frames were"), pacer.longest_pause(),
                    pacer.paused_at()));
  if (stall > stale)
    result.notes.push_back(fmt::format(
        "the planner stood still for {:.3g} s: the watchdog fades the force out after {:g} s of it", stall,
        stale));
}

// States that become known by themselves. They are solved before the first frame.
struct Arriving {
  std::span<const Arrival> at;
  std::vector<State> states = {};
  std::size_t arrived = 0;

  void solve(ReferenceService& references, const ShowProgress& show) {
    for (const Arrival& arrival : at) references.request(arrival.at, arrival.site);
    for (const Arrival& arrival : at) {
      states.push_back(references.get(arrival.at, arrival.site));
      if (show)
        show({.phase = SessionPhase::arrivals,
              .t = static_cast<double>(states.size()),
              .seconds = static_cast<double>(at.size()),
              .known = states.size()});
    }
  }
  void pass(Planner& planner, double now) {
    while (arrived < states.size() && at[arrived].t <= now) planner.arrive(std::move(states[arrived++]), now);
  }
};

// The planner's thread.
struct PlannerRun {
  Planner& planner;
  ModelMaker& models;
  RealWorkers& workers;
  LoopLink& link;
  Arriving arriving;
  bool dispatches;
  double stale;  // of the watchdog [s]
  Nanoseconds start;
  ShapeThread* shapes = nullptr;
  PlannerTimes times = {};

  double now() const { return static_cast<double>(monotonic() - start) / 1e9; }

  void step(std::vector<JobResult>& results) {
    results.clear();
    collect(results);
    for (JobResult& result : results) planner.receive(std::move(result), now());
    arriving.pass(planner, now());
    if (const auto hip = link.hip.take()) {
      planner.observe(*hip);
      if (shapes) shapes->pass(*hip, planner.space());
    }
    link.known.store(planner.known(), std::memory_order_release);
    models.update(now(), planner.hip().at, true);
    if (dispatches && !workers.failure()) planner.plan(now());
    const double t = now();
    times.step(t, stale);
    link.planner_beat.store(t, std::memory_order_relaxed);
  }

  // Failed workers are not waited for.
  void collect(std::vector<JobResult>& results) {
    constexpr double longest = 0.0005;  // [s]
    workers.collect(results, longest);
    if (workers.failure()) std::this_thread::sleep_for(std::chrono::duration<double>(longest));
  }

  void until(const LoopEnd& end, double seconds, const ShowProgress& show) {
    std::vector<JobResult> results;
    double shown = 0;
    while (!end.done.load(std::memory_order_acquire)) {
      step(results);
      if (show && now() - shown > 0.1) {
        shown = now();
        show({.phase = SessionPhase::session,
              .t = shown,
              .seconds = seconds,
              .known = planner.known(),
              .solved = planner.solved(),
              .label = models.label()});
      }
    }
  }

  // Keeps the states that were solved after the last frame.
  void keep_rest() {
    std::vector<JobResult> results;
    workers.collect(results, 0);
    for (JobResult& result : results)
      if (result.state.solve.status != SolveStatus::cancelled) planner.receive(std::move(result), now());
  }
};

// asked: for how many; 0: nothing was solved.
void report_workers(const RealWorkers& workers, int asked, SessionResult& result) {
  result.solver.workers = asked > 0 ? workers.workers() : 0;
  result.solver.lost = workers.lost();
  if (workers.failure())
    result.failures.push_back(failure_in_words("the workers", workers.failure(), "nothing more was solved"));
  for (std::string& note : workers.notes()) result.notes.push_back(std::move(note));
  if (workers.serves() && !result.interrupted() && workers.workers() < asked)
    result.notes.push_back(fmt::format("{} of {} ran: the OpenMP runtime gave no more threads",
                                       workers.workers(),
                                       counted(static_cast<std::size_t>(asked), "worker")));
}

// The calling thread and its team are the workers until they are stopped.
void serve(RealWorkers& workers, const RunSolving& solving) {
  const bool serving = solving.dispatches && workers.serves();
  const int team = serving ? solving.options.count : 1;
  omp_set_dynamic(0);
#pragma omp parallel num_threads(team)
  {
    if (serving) workers.serve();
  }
}

std::shared_ptr<RealWorkers> workers_of(const RunSolving& solving) {
  if (solving.real) return solving.real;
  if (solving.options.ranks) return make_rank_workers(*solving.options.ranks);
  return make_real_workers(solving.options.kind, solving.context);
}

}  // namespace

void run_real(const RunSetup& setup, ReferenceService& references, SessionResult& result,
              const ShowProgress& show, const RunLogs& logs) {
  const RunMotion& motion = setup.motion;
  const RunSolving& solving = setup.solving;
  const double stale = setup.rendering.options.safety.stale_seconds;
  Arriving arriving{.at = solving.arrivals};
  arriving.solve(references, show);
  StateLog states(setup.record);

  LoopLink link;
  link.inputs = logs.inputs;
  Nanoseconds start = 0;
  const auto session_time = [&start] { return static_cast<double>(monotonic() - start) / 1e9; };
  RenderLoop loop(*motion.device, link, setup.rendering.options, motion.frames,
                  {.now = session_time, .spare = spare_frames}, setup.rendering.contact(link));
  const LockedMemory locked(result);
  start = monotonic() + 20000000;  // threads are up by then
  const std::shared_ptr<RealWorkers> given = workers_of(solving);
  RealWorkers& workers = *given;
  workers.begin([start] { return static_cast<double>(monotonic() - start) / 1e9; });
  Planner planner(setup.planning, workers, hooks_of(setup, states, logs.inputs));
  link.known.store(planner.known(), std::memory_order_release);
  const std::unique_ptr<ModelMaker> maker = setup.rendering.maker(planner.space(), link);
  ModelMaker& models = *maker;
  PlannerRun run{planner, models, workers, link, std::move(arriving), solving.dispatches, stale, start};
  FramePacer pacer(motion.clock.frame, motion.frames);
  LoopEnd end;
  std::exception_ptr failure;

  std::thread loop_thread([&] { run_loop(loop, pacer, motion.stop, start, end); });
  std::optional<ShapeThread> shape_thread;  // after the loop's, which must not wait for it
  if (logs.shapes) run.shapes = &shape_thread.emplace(*logs.shapes, session_time);
  std::thread planner_thread([&] {
    try {
      run.until(end, motion.clock.seconds, show);
    } catch (...) {
      failure = std::current_exception();
    }
    end.wanted.store(true, std::memory_order_release);  // without a planner the force goes to zero
    workers.stop();
  });
  serve(workers, solving);
  planner_thread.join();
  loop_thread.join();
  if (shape_thread) shape_thread->end();
  if (!failure) run.keep_rest();
  if (logs.inputs && setup.rendering.surface) logs.inputs->learn(setup.rendering.surface->known());
  if (logs.inputs && !setup.rendering.surface)
    logs.inputs->learn(planner.space());  // also what came after the last model
  states.flush();
  if (states.failure()) result.failures.push_back(*states.failure());
  if (failure) result.failures.push_back(failure_in_words("planning", failure));
  if (shape_thread && shape_thread->failure()) result.failures.push_back(*shape_thread->failure());

  take_loop(loop, motion.frames, result);
  report(pacer, run.times, motion.frames, stale, result);
  planner.finish(result, models);
  result.run.realtime_priority = end.realtime;
  if (!end.note.empty()) result.notes.push_back(end.note);
  report_workers(workers, solving.dispatches ? solving.options.count : 0, result);
}

}  // namespace forefeel
