// Virtual clock: a discrete-event simulation of the planner and loop. Time is integer nanoseconds; events are in a
// total order (time, kind, sequence): results first, then planning, then the frame of that instant. State values are
// the reference branch's, solved on real threads from the moment they are dispatched: how long that takes changes
// nothing but the wait.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <queue>
#include <tuple>

#include "scheduling/session/session_parts.hpp"
#include "scheduling/workers/cost.hpp"

namespace forefeel {
namespace {

using Nanoseconds = std::int64_t;
constexpr double for_ever =
    1e8;  // [s], three years: no run is longer, and sums of a few such times still fit
Nanoseconds ns(double seconds) {
  return std::llround(std::min(seconds, for_ever) * 1e9);
}
double seconds(Nanoseconds t) {
  return static_cast<double>(t) / 1e9;
}

enum class Kind { result, arrival, plan, frame };

struct Event {
  Nanoseconds t = 0;
  Kind kind = Kind::frame;
  std::uint64_t sequence = 0;
  std::uint64_t payload = 0;  // worker, arrival or frame

  friend bool operator>(const Event& a, const Event& b) {
    return std::tie(a.t, a.kind, a.sequence) > std::tie(b.t, b.kind, b.sequence);
  }
};

class EventQueue {
 public:
  void push(Nanoseconds t, Kind kind, std::uint64_t payload) { queue_.push({t, kind, sequence_++, payload}); }
  bool empty() const { return queue_.empty(); }
  Event pop() {
    const Event event = queue_.top();
    queue_.pop();
    return event;
  }

 private:
  std::priority_queue<Event, std::vector<Event>, std::greater<>> queue_;
  std::uint64_t sequence_ = 0;
};

// Simulated workers: a job reaches them a message later, each of its states takes what the cost model says (a neighbour
// of the first its share of that), and its result comes a message after. A cancellation that arrives in time gives the
// worker back two messages after it was sent; the work done on a state until then is not done again.
class SimulatedWorkers final : public Generator {
 public:
  SimulatedWorkers(int workers, const SessionOptions& options, const CostModel& cost,
                   ReferenceService& references, EventQueue& events)
      : cost_(cost),
        rest_first_(options.planning.rest_first),
        share_(options.workers.batch_share),
        latency_(ns(options.workers.latency)),
        references_(references),
        events_(events),
        running_(static_cast<std::size_t>(workers)) {}

  void set_now(Nanoseconds now) { now_ = now; }
  int workers() const override { return static_cast<int>(running_.size()); }

  void dispatch(int worker, Job job) override {
    std::vector<Solve>& solves = running_[static_cast<std::size_t>(worker)];
    solves.clear();
    Nanoseconds begin = add(solves, worker, job.dispatch, job.at, 1, now_ + latency_);
    for (const Job::Neighbour& neighbour : job.beside)
      begin = add(solves, worker, neighbour.dispatch, neighbour.at, share_, begin);
  }

  void cancel(int worker) override {
    const Nanoseconds arrives = now_ + latency_;
    bool any = false;
    for (Solve& solve : running_[static_cast<std::size_t>(worker)]) {
      if (solve.returned || arrives >= solve.finished) continue;  // solved before the message arrives
      if (arrives > solve.started) done_[solve.at] += arrives - solve.started;
      solve.cancelled = any = true;
      solve.started = std::min(solve.started, arrives);
      solve.finished = arrives;
      solve.due = arrives + latency_;
    }
    if (any) events_.push(arrives + latency_, Kind::result, static_cast<std::uint64_t>(worker));
  }

  // What is due at this event: nothing for states that were cancelled since.
  void take(const Event& event, std::vector<JobResult>& results) {
    results.clear();
    for (Solve& solve : running_[event.payload]) {
      if (solve.returned || solve.due != event.t) continue;
      solve.returned = true;
      JobResult& result = results.emplace_back();
      result.dispatch = solve.dispatch;
      result.worker = static_cast<int>(event.payload);
      result.started = seconds(solve.started);
      result.finished = seconds(solve.finished);
      if (solve.cancelled)
        result.state.status = SolveStatus::cancelled;
      else
        result.state = references_.get(solve.at);
    }
  }

 private:
  struct Solve {
    std::uint32_t dispatch = 0;
    Vec3 at = Vec3::Zero();
    Nanoseconds started = 0, finished = 0, due = 0;
    bool cancelled = false, returned = false;
  };
  struct ByPlace {
    bool operator()(const Vec3& a, const Vec3& b) const {
      return std::tie(a[0], a[1], a[2]) < std::tie(b[0], b[1], b[2]);
    }
  };

  Nanoseconds add(std::vector<Solve>& solves, int worker, std::uint32_t dispatch, const Vec3& at,
                  double share, Nanoseconds begin) {
    Nanoseconds cost = ns(share * (rest_first_ && at.isZero(0) ? cost_.rest_seconds() : cost_.seconds(at)));
    if (const auto done = done_.find(at); done != done_.end()) cost -= done->second;
    const Nanoseconds end = begin + std::max<Nanoseconds>(1, cost);
    solves.push_back(
        {.dispatch = dispatch, .at = at, .started = begin, .finished = end, .due = end + latency_});
    references_.request(at);
    events_.push(end + latency_, Kind::result, static_cast<std::uint64_t>(worker));
    return end;
  }

  const CostModel& cost_;
  bool rest_first_;
  double share_;
  Nanoseconds latency_, now_ = 0;
  ReferenceService& references_;
  EventQueue& events_;
  std::vector<std::vector<Solve>> running_;
  std::map<Vec3, Nanoseconds, ByPlace> done_;  // on states whose solve was broken off
};

// Models and rendering beside the planner, which does not depend on them where the motion does not depend on the force: they
// follow it on the thread of the analysis, with the states that were known in each frame.
class RenderAside {
 public:
  RenderAside(const StateSpace& space, const SessionPlan& plan)
      : models_(space, plan.model, link_),
        loop_(motion_, link_, plan.render, plan.frames),
        frame_(plan.render.frame) {}

  void frame(std::size_t k, const Vec3& at, std::uint32_t known) {
    const double now = seconds(ns(static_cast<double>(k) * frame_));
    models_.update(now, motion_.at);  // for where the HIP was seen last
    motion_.at = at;
    link_.known.store(known, std::memory_order_relaxed);
    link_.planner_beat.store(now, std::memory_order_relaxed);
    loop_.frame(k);
    force_.store(loop_.log()[k].force.norm(), std::memory_order_relaxed);
    label_.store(models_.label(), std::memory_order_relaxed);
  }
  ModelKeeper& models() { return models_; }
  RenderLoop& loop() { return loop_; }
  double force() const {
    return force_.load(std::memory_order_relaxed);
  }  // of a frame done lately, on any thread
  Label label() const { return label_.load(std::memory_order_relaxed); }

 private:
  struct Motion final : Device {
    Vec3 position(double, const Vec3&) noexcept override { return at; }
    double duration() const override { return std::numeric_limits<double>::infinity(); }
    Vec3 at = Vec3::Zero();
  };
  LoopLink link_;
  Motion motion_;
  ModelKeeper models_;
  RenderLoop loop_;
  double frame_;
  std::atomic<double> force_{0};
  std::atomic<Label> label_{Label::blank};
};

}  // namespace

void run_virtual(const SessionPlan& plan, const CostModel& cost, ReferenceService& references,
                 RunAnalysis& analysis, SessionResult& result, const ShowProgress& show) {
  const SessionOptions& options = plan.options;
  EventQueue events;
  std::vector<JobResult> results;
  LoopLink link;
  SimulatedWorkers workers(plan.given_arrivals ? 0 : options.workers.count, options, cost, references,
                           events);
  const std::unique_ptr<StateWriter> writer = open_state_file(plan.input);
  Planner planner(planner_setup(plan), workers, link, hooks_of(plan, &cost, writer.get()));
  // Either the one or the other renders.
  std::shared_ptr<RenderAside> aside;
  std::optional<RenderLoop> loop;
  if (plan.device->answers_force()) {
    loop.emplace(*plan.device, link, plan.render, plan.frames);
  } else {
    aside = std::make_shared<RenderAside>(analysis.space(), plan);
    analysis.begin(
        [aside](std::size_t k, const Vec3& at, std::uint32_t known) { aside->frame(k, at, known); });
  }
  HipSample hip;

  for (std::size_t i = 0; i < plan.arrivals.size(); ++i) {
    if (plan.arrivals[i].t > options.clock.seconds) break;
    references.request(plan.arrivals[i].at);
    events.push(ns(plan.arrivals[i].t), Kind::arrival, i);
  }
  events.push(0, Kind::frame, 0);
  while (!events.empty()) {
    const Event event = events.pop();
    const double now = seconds(event.t);
    workers.set_now(event.t);
    if (event.kind == Kind::result) {
      workers.take(event, results);
      for (JobResult& done : results) planner.receive(std::move(done), now);
      if (!results.empty()) events.push(event.t, Kind::plan, 0);
    } else if (event.kind == Kind::arrival) {
      planner.arrive(references.get(plan.arrivals[event.payload].at), now);
    } else if (event.kind == Kind::plan) {
      planner.plan(now);
    } else {
      // A model made now is rendered now: states and motion up to this instant, at most one update a frame.
      if (loop) {
        planner.update(now);
        link.planner_beat.store(now, std::memory_order_relaxed);
        loop->frame(event.payload);
        hip = loop->hip();
      } else {
        hip = next_hip(*plan.device, hip, event.payload, options.clock.frame, Vec3::Zero());
      }
      analysis.frame(hip.at, link.known.load(std::memory_order_relaxed), planner.space());
      planner.observe(hip);
      planner.plan(now);
      const std::size_t next = event.payload + 1;
      if (next == plan.frames || options.stop.is_interrupted()) break;
      events.push(ns(static_cast<double>(next) * options.clock.frame), Kind::frame, next);
      if (show && next % 250 == 0)
        show({.phase = SessionPhase::session,
              .t = now,
              .seconds = options.clock.seconds,
              .known = planner.space().size(),
              .solved = planner.solved(),
              .label = aside ? aside->label() : planner.label(),
              .force = aside ? aside->force() : loop->log()[event.payload].force.norm()});
    }
  }
  if (writer) writer->flush();
  if (aside) analysis.catch_up(planner.space());
  take_loop(aside ? aside->loop() : *loop, plan.frames, result);
  if (aside)
    planner.finish(result, aside->models());
  else
    planner.finish(result);
  result.solver.workers = workers.workers();
}

}  // namespace forefeel
