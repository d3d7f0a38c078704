#include "scheduling/session/real_run.hpp"

#include <fmt/format.h>
#include <omp.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <thread>

#include "scheduling/session/run_parts.hpp"
#include "scheduling/workers/mpi_workers.hpp"

namespace forefeel {
namespace {

using Nanoseconds = std::int64_t;

Nanoseconds monotonic() {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return Nanoseconds{now.tv_sec} * 1000000000 + now.tv_nsec;
}

void sleep_until(Nanoseconds t) {
  const timespec until{.tv_sec = t / 1000000000, .tv_nsec = t % 1000000000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

// Locked pages for the time of a session; says so where the system does not permit it.
class LockedMemory {
 public:
  explicit LockedMemory(SessionResult& result) {
    // Under a limit, later allocations would fail once it is reached: lock only what is there.
    rlimit limit{};
    const bool unlimited =
        geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
    locked_ = mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT) == 0;
    if (!locked_) result.notes.push_back(fmt::format("memory is not locked: {}", std::strerror(errno)));
    result.process.memory_locked = locked_;
  }
  ~LockedMemory() {
    if (locked_) munlockall();
  }
  LockedMemory(const LockedMemory&) = delete;
  LockedMemory& operator=(const LockedMemory&) = delete;

 private:
  bool locked_ = false;
};

// What the loop's thread reports when it ends.
struct LoopEnd {
  std::atomic<bool> done{false};
  bool realtime = false;
  std::string note;
};

void run_loop(RenderLoop& loop, std::size_t frames, const SessionOptions& options, Nanoseconds start,
              LoopEnd& end) {
  const sched_param priority{.sched_priority = 80};
  const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
  end.realtime = refused == 0;
  if (refused) end.note = fmt::format("the loop runs without real-time priority: {}", std::strerror(refused));
  for (std::size_t k = 0; k < frames && !options.stop.is_interrupted(); ++k) {
    const Nanoseconds due = start + std::llround(static_cast<double>(k) * options.clock.frame * 1e9);
    sleep_until(due);
    const Nanoseconds woke = monotonic();
    loop.frame(k);
    loop.note_timing(static_cast<double>(monotonic() - woke) / 1e3, static_cast<double>(woke - due) / 1e3);
  }
  end.done.store(true, std::memory_order_release);
}

// Solves what --arrivals and --replay will deliver, before the first frame.
std::vector<State> solve_arrivals(const SessionPlan& plan, ReferenceService& references,
                                  const ShowProgress& show) {
  for (const Arrival& arrival : plan.arrivals) references.request(arrival.at);
  std::vector<State> states;
  for (const Arrival& arrival : plan.arrivals) {
    states.push_back(references.get(arrival.at));
    if (show)
      show({.phase = SessionPhase::arrivals,
            .t = static_cast<double>(states.size()),
            .seconds = static_cast<double>(plan.arrivals.size()),
            .known = states.size()});
  }
  return states;
}

// The planner's thread.
struct PlannerRun {
  const SessionPlan& plan;
  Planner& planner;
  ModelKeeper& models;
  RealWorkers& workers;
  LoopLink& link;
  std::vector<State> arriving;
  Nanoseconds start;
  const ShowProgress& show;

  double now() const { return static_cast<double>(monotonic() - start) / 1e9; }

  void step(std::vector<JobResult>& results, std::size_t& arrived) {
    workers.collect(results, 0.0005);
    for (JobResult& result : results) planner.receive(std::move(result), now());
    while (arrived < arriving.size() && plan.arrivals[arrived].t <= now())
      planner.arrive(std::move(arriving[arrived++]), now());
    if (const auto hip = link.hip.take()) planner.observe(*hip);
    link.known.store(static_cast<std::uint32_t>(planner.space().size()), std::memory_order_release);
    models.update(now(), planner.hip().at, true);
    if (!plan.given_arrivals) planner.plan(now());
    link.planner_beat.store(now(), std::memory_order_relaxed);
  }

  void until(const LoopEnd& end) {
    std::vector<JobResult> results;
    std::size_t arrived = 0;
    double shown = 0;
    while (!end.done.load(std::memory_order_acquire) && !workers.failure()) {
      step(results, arrived);
      if (show && now() - shown > 0.1) {
        shown = now();
        show({.phase = SessionPhase::session,
              .t = shown,
              .seconds = plan.options.clock.seconds,
              .known = planner.space().size(),
              .solved = planner.solved(),
              .label = models.label()});
      }
    }
  }

  // What was solved meanwhile is kept.
  void keep_rest() {
    std::vector<JobResult> results;
    workers.collect(results, 0);
    for (JobResult& result : results)
      if (result.state.status != SolveStatus::cancelled) planner.receive(std::move(result), now());
  }
};

std::shared_ptr<RealWorkers> workers_of(const SessionPlan& plan) {
  const TouchedBody& touched = plan.input.touched;
  const WorkerOptions& options = plan.options.workers;
  if (plan.input.parts.workers) return plan.input.parts.workers;
  if (options.mpi) return options.mpi->workers();
  return make_real_workers(options.kind, {.body = touched.body,
                                          .solving = {.spacing = touched.space.spacing,
                                                      .tolerance = 1e-6,
                                                      .displacements = touched.displacements},
                                          .count = options.count});
}

}  // namespace

void run_real(const SessionPlan& plan, ReferenceService& references, SessionResult& result,
              const ShowProgress& show) {
  const SessionOptions& options = plan.options;
  std::vector<State> arriving = solve_arrivals(plan, references, show);
  const std::unique_ptr<StateWriter> writer = open_state_file(plan.input);

  LoopLink link;
  RenderLoop loop(*plan.device, link, plan.render, plan.frames);
  const LockedMemory locked(result);
  const Nanoseconds start = monotonic() + 20000000;  // threads are up by then
  const auto session_time = [start] { return static_cast<double>(monotonic() - start) / 1e9; };
  const std::shared_ptr<RealWorkers> given = workers_of(plan);
  RealWorkers& workers = *given;
  workers.begin(session_time);
  Planner planner(planner_setup(plan), workers, hooks_of(plan, nullptr, writer.get()));
  link.known.store(static_cast<std::uint32_t>(planner.space().size()), std::memory_order_release);
  ModelKeeper models(planner.space(), plan.model, link);
  PlannerRun run{plan, planner, models, workers, link, std::move(arriving), start, show};
  LoopEnd end;
  std::exception_ptr failure;

  std::thread loop_thread([&] { run_loop(loop, plan.frames, options, start, end); });
  std::thread planner_thread([&] {
    try {
      run.until(end);
    } catch (...) {
      failure = std::current_exception();
    }
    workers.stop();
  });
  const bool serving = !plan.given_arrivals && workers.serves();
  const int team = serving ? options.workers.count : 1;
  omp_set_dynamic(0);
#pragma omp parallel num_threads(team)
  {
    if (serving) workers.serve();
  }
  planner_thread.join();
  loop_thread.join();
  if (!failure) run.keep_rest();
  if (writer) writer->flush();
  if (failure) std::rethrow_exception(failure);
  if (workers.failure()) std::rethrow_exception(workers.failure());

  take_loop(loop, plan.frames, result);
  planner.finish(result, models);
  result.solver.workers = plan.given_arrivals ? 0 : workers.workers();
  result.process.realtime_priority = end.realtime;
  if (!end.note.empty()) result.notes.push_back(end.note);
  if (serving && result.frames.size() == plan.frames && workers.workers() < options.workers.count)
    result.notes.push_back(fmt::format("{} of {} workers ran: the OpenMP runtime gave no more threads",
                                       workers.workers(), options.workers.count));
}

}  // namespace forefeel
