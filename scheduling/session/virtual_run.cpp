#include "scheduling/session/virtual_run.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>
#include <queue>
#include <tuple>

#include "scheduling/render/input_log.hpp"
#include "scheduling/session/run_parts.hpp"
#include "scheduling/session/session_setup.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/reference_service.hpp"

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

std::shared_ptr<VirtualWorkers> workers_of(const SessionPlan& plan, const CostModel& cost,
                                           ReferenceService& references) {
  const WorkerOptions& options = plan.options.workers;
  if (plan.input.parts.virtual_workers && !plan.arrivals.given) return plan.input.parts.virtual_workers;
  return make_virtual_workers(options.kind, {.references = references,
                                             .cost = cost,
                                             .count = plan.arrivals.given ? 0 : options.count,
                                             .rest_first = plan.options.planning.rest_first,
                                             .batch_share = options.batch_share,
                                             .latency = options.latency});
}

class VirtualRun {
 public:
  VirtualRun(const SessionPlan& plan, const VirtualParts& parts, const ShowProgress& show)
      : plan_(plan),
        parts_(parts),
        show_(show),
        workers_(workers_of(plan, parts.cost, parts.references)),
        states_(plan.input),
        planner_(planner_setup(plan), *workers_, hooks_of(plan, &parts.cost, states_, parts.inputs)) {
    if (parts.renderer) return;
    link_.inputs = parts.inputs;
    models_.emplace(planner_.space(), plan.model, link_);
    loop_.emplace(*plan.device, link_, plan.render, plan.frames);
  }

  void run() {
    const std::vector<Arrival>& arrivals = plan_.arrivals.list;
    for (std::size_t i = 0; i < arrivals.size() && arrivals[i].t <= plan_.options.clock.seconds; ++i) {
      parts_.references.request(arrivals[i].at);
      events_.push(ns(arrivals[i].t), Kind::arrival, i);
    }
    events_.push(0, Kind::frame, 0);
    while (const std::optional<Event> event = next_event()) {
      const double now = seconds(event->t);
      workers_->set_now(VirtualWorkers::Time(event->t));
      if (event->kind == Kind::result)
        take_results(*event);
      else if (event->kind == Kind::arrival)
        planner_.arrive(parts_.references.get(arrivals[event->payload].at), now);
      else if (event->kind == Kind::plan)
        planner_.plan(now);
      else if (!frame(event->payload, now))
        break;
    }
    states_.flush();
  }

  // Adds the frames of a session that ends early, in which the force goes to zero. Nothing more is planned. There are
  // as many frames as the largest force may need, because a following renderer has not yet reported the actual force.
  void end_early() {
    const SafetyOptions& limits = plan_.render.safety;
    const double needed = std::ceil(limits.force_limit / (limits.slew_limit * plan_.render.frame));
    const std::size_t last = std::min(plan_.frames, next_ + static_cast<std::size_t>(std::min(needed, 1e3)));
    for (; next_ < last; ++next_) {
      if (loop_) {
        loop_->end();
        loop_->frame(next_);
        hip_ = loop_->hip();
      } else {
        hip_ = next_hip(*plan_.device, hip_, next_, plan_.render.frame, Vec3::Zero(), held_);
      }
      const std::size_t known = planner_.space().size();
      parts_.pipeline.pass(hip_.at, static_cast<std::uint32_t>(known), planner_.space(), true);
    }
  }

  void finish(SessionResult& result) {
    if (parts_.renderer) {
      parts_.pipeline.flush(planner_.space());
      parts_.pipeline.wait();
    }
    take_loop(parts_.renderer ? parts_.renderer->loop() : *loop_, plan_.frames, result);
    if (states_.failure()) result.failures.push_back(*states_.failure());
    planner_.finish(result, parts_.renderer ? parts_.renderer->models() : *models_);
    result.loop.device_held += held_;
    result.solver.workers = workers_->workers();
  }

 private:
  // Events of the workers come before other events of the same time.
  std::optional<Event> next_event() {
    const std::optional<VirtualWorkers::Time> due = workers_->next_event();
    if (due && (events_.empty() || due->count() <= events_.next()))
      return Event{.t = due->count(), .kind = Kind::result};
    if (events_.empty()) return {};
    return events_.pop();
  }

  void take_results(const Event& event) {
    results_.clear();
    workers_->take_event(results_);
    for (JobResult& done : results_) planner_.receive(std::move(done), seconds(event.t));
    if (!results_.empty()) events_.push(event.t, Kind::plan, 0);
  }

  // Returns whether another frame follows. Without a following renderer, a model is made and rendered in this frame,
  // from the states and the motion up to now; at most one update per frame.
  bool frame(std::size_t k, double now) {
    const auto known = static_cast<std::uint32_t>(planner_.space().size());
    if (loop_) {
      models_->update(now, hip_.at);
      link_.known.store(known, std::memory_order_relaxed);
      link_.planner_beat.store(now, std::memory_order_relaxed);
      loop_->frame(k);
      if (link_.inputs && k % 1024 == 1023) link_.inputs->drain();
      hip_ = loop_->hip();
    } else {
      hip_ = next_hip(*plan_.device, hip_, k, plan_.render.frame, Vec3::Zero(), held_);
    }
    parts_.pipeline.pass(hip_.at, known, planner_.space());
    planner_.observe(hip_);
    planner_.plan(now);
    next_ = k + 1;
    if (next_ == plan_.frames) return false;
    if (plan_.options.stop.is_interrupted()) {
      end_early();
      return false;
    }
    events_.push(ns(static_cast<double>(k + 1) * plan_.render.frame), Kind::frame, k + 1);
    if (show_ && (k + 1) % 250 == 0) show_progress(k, now);
    return true;
  }

  void show_progress(std::size_t k, double now) const {
    const FollowingRenderer* behind = parts_.renderer;
    show_({.phase = SessionPhase::session,
           .t = now,
           .seconds = plan_.options.clock.seconds,
           .known = planner_.space().size(),
           .solved = planner_.solved(),
           .label = behind ? behind->label() : models_->label(),
           .force = behind ? behind->force() : loop_->log()[k].force.norm()});
  }

  const SessionPlan& plan_;
  const VirtualParts& parts_;
  const ShowProgress& show_;
  EventQueue events_;
  std::vector<JobResult> results_;
  std::shared_ptr<VirtualWorkers> workers_;
  StateLog states_;
  Planner planner_;
  HipSample hip_;
  std::size_t next_ = 0;  // frame
  std::size_t held_ = 0;  // frames in which the device failed, with a renderer that follows behind
  // Used if the motion depends on the force: then a following renderer is impossible.
  LoopLink link_;
  std::optional<ModelKeeper> models_;
  std::optional<RenderLoop> loop_;
};

}  // namespace

void run_virtual(const SessionPlan& plan, const VirtualParts& parts, SessionResult& result,
                 const ShowProgress& show) {
  VirtualRun run(plan, parts, show);
  std::exception_ptr failure;
  try {
    run.run();
  } catch (...) {
    failure = std::current_exception();
    run.end_early();
  }
  run.finish(result);
  if (failure) result.failures.push_back(failure_in_words("planning", failure));
}

}  // namespace forefeel
