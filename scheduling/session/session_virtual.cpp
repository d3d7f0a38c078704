// Virtual clock: a discrete-event simulation of the planner and loop. Time is in whole nanoseconds. Events have a total
// order (time, kind, sequence): the workers' results first, then arrivals, then planning, then the frame of that instant.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
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
  std::uint64_t payload = 0;  // arrival or frame

  friend bool operator>(const Event& a, const Event& b) {
    return std::tie(a.t, a.kind, a.sequence) > std::tie(b.t, b.kind, b.sequence);
  }
};

class EventQueue {
 public:
  void push(Nanoseconds t, Kind kind, std::uint64_t payload) { queue_.push({t, kind, sequence_++, payload}); }
  bool empty() const { return queue_.empty(); }
  Nanoseconds next() const { return queue_.top().t; }
  Event pop() {
    const Event event = queue_.top();
    queue_.pop();
    return event;
  }

 private:
  std::priority_queue<Event, std::vector<Event>, std::greater<>> queue_;
  std::uint64_t sequence_ = 0;
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

std::shared_ptr<VirtualWorkers> workers_of(const SessionPlan& plan, const CostModel& cost,
                                           ReferenceService& references) {
  const WorkerOptions& options = plan.options.workers;
  if (plan.input.parts.virtual_workers && !plan.given_arrivals) return plan.input.parts.virtual_workers;
  return make_virtual_workers(options.kind, {.references = references,
                                             .cost = cost,
                                             .count = plan.given_arrivals ? 0 : options.count,
                                             .rest_first = plan.options.planning.rest_first,
                                             .batch_share = options.batch_share,
                                             .latency = options.latency});
}

}  // namespace

void run_virtual(const SessionPlan& plan, const CostModel& cost, ReferenceService& references,
                 RunAnalysis& analysis, SessionResult& result, const ShowProgress& show) {
  const SessionOptions& options = plan.options;
  EventQueue events;
  std::vector<JobResult> results;
  LoopLink link;
  const std::shared_ptr<VirtualWorkers> given = workers_of(plan, cost, references);
  VirtualWorkers& workers = *given;
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
  for (;;) {
    const std::optional<VirtualWorkers::Time> due = workers.next_event();
    if (!due && events.empty()) break;
    const bool of_workers = due && (events.empty() || due->count() <= events.next());
    const Event event = of_workers ? Event{.t = due->count(), .kind = Kind::result} : events.pop();
    const double now = seconds(event.t);
    workers.set_now(VirtualWorkers::Time(event.t));
    if (event.kind == Kind::result) {
      workers.take_event(results);
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
