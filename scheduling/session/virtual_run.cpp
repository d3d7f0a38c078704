#include "scheduling/session/virtual_run.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <queue>
#include <span>
#include <tuple>

#include "scheduling/render/input_log.hpp"
#include "scheduling/session/run_parts.hpp"
#include "scheduling/session/session_setup.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

FollowingRenderer::FollowingRenderer(const StateSpace& known, const RunRendering& rendering,
                                     std::size_t frames, InputLog* inputs)
    : models_(known, rendering.model, link_),
      loop_(motion_, link_, rendering.options, frames),
      frame_(rendering.options.frame) {
  link_.inputs = inputs;
}

double FollowingRenderer::Motion::duration() const {
  return std::numeric_limits<double>::infinity();
}

void FollowingRenderer::frame(const PassedFrame& frame) {
  const double now = frame_time(frame.k, frame_);
  models_.update(now, motion_.at);  // for the last known position of the HIP
  motion_.at = frame.at;
  link_.known.store(frame.known, std::memory_order_relaxed);
  link_.planner_beat.store(now, std::memory_order_relaxed);
  if (frame.ending) loop_.end();
  loop_.frame(frame.k);
  if (link_.inputs && frame.k % 1024 == 1023) link_.inputs->drain();
  force_.store(loop_.log()[frame.k].force.norm(), std::memory_order_relaxed);
  label_.store(models_.label(), std::memory_order_relaxed);
}

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

std::shared_ptr<VirtualWorkers> workers_of(const RunSolving& solving, ReferenceService& references) {
  const WorkerOptions& options = solving.options;
  if (solving.simulated && solving.dispatches) return solving.simulated;
  return make_virtual_workers(options.kind, {.references = references,
                                             .cost = *solving.cost,
                                             .count = solving.dispatches ? options.count : 0,
                                             .rest_first = solving.rest_first,
                                             .batch_share = options.batch_share,
                                             .latency = options.latency});
}

// Renders in the frame itself: for a motion that depends on the force, and for sites, which the planner must know; no
// renderer can follow these.
struct OwnRenderer {
  LoopLink link;
  std::unique_ptr<ModelMaker> models;
  RenderLoop loop;

  OwnRenderer(const RunSetup& setup, const StateSpace& space, InputLog* inputs)
      : models(setup.rendering.maker(space, link)),
        loop(*setup.motion.device, link, setup.rendering.options, setup.motion.frames, {},
             setup.rendering.contact(link)) {
    link.inputs = inputs;
  }
  // From the states and the motion up to now; at most one new model per frame.
  void frame(std::size_t k, double now, std::uint32_t known) {
    models->update(now, loop.hip().at);
    link.known.store(known, std::memory_order_relaxed);
    link.planner_beat.store(now, std::memory_order_relaxed);
    loop.frame(k);
    if (link.inputs && k % 1024 == 1023) link.inputs->drain();
  }
};

class VirtualRun {
 public:
  VirtualRun(const RunSetup& setup, const VirtualParts& parts, const ShowProgress& show)
      : motion_(setup.motion),
        arrivals_(setup.solving.arrivals),
        parts_(parts),
        show_(show),
        workers_(workers_of(setup.solving, parts.references)),
        states_(setup.record),
        planner_(setup.planning, *workers_, hooks_of(setup, states_, parts.inputs)),
        tip_(*motion_.device, motion_.clock.frame, std::numeric_limits<double>::infinity()) {
    if (!parts.renderer) own_.emplace(setup, planner_.space(), parts.inputs);
  }

  void run() {
    for (std::size_t i = 0; i < arrivals_.size() && arrivals_[i].t <= motion_.clock.seconds; ++i) {
      parts_.references.request(arrivals_[i].at, arrivals_[i].site);
      events_.push(ns(arrivals_[i].t), Kind::arrival, i);
    }
    events_.push(0, Kind::frame, 0);
    while (const std::optional<Event> event = next_event()) {
      const double now = seconds(event->t);
      workers_->set_now(VirtualWorkers::Time(event->t));
      if (event->kind == Kind::result)
        take_results(*event);
      else if (event->kind == Kind::arrival)
        planner_.arrive(parts_.references.get(arrivals_[event->payload].at, arrivals_[event->payload].site),
                        now);
      else if (event->kind == Kind::plan)
        planner_.plan(now);
      else if (!frame(event->payload, now))
        break;
    }
    states_.flush();
  }

  // Adds the frames of a session that ends early, in which the force goes to zero. Nothing more is planned. There are
  // as many frames as the largest force may need, because a following renderer has not yet reported the actual force.
  void end_early(const SafetyOptions& limits) {
    const double needed = std::ceil(limits.force_limit / (limits.slew_limit * motion_.clock.frame));
    const std::size_t last =
        std::min(motion_.frames, next_ + static_cast<std::size_t>(std::min(needed, 1e3)));
    for (; next_ < last; ++next_) {
      if (own_) {
        own_->loop.end();
        own_->loop.frame(next_);
      } else {
        tip_.read(next_, Vec3::Zero());
      }
      parts_.pipeline.pass(hip().at, planner_.known(), planner_.space(), true);
    }
  }
  bool interrupted() const { return interrupted_; }

  void finish(SessionResult& result) {
    if (parts_.renderer) {
      parts_.pipeline.flush(planner_.space());
      parts_.pipeline.wait();
    }
    take_loop(own_ ? own_->loop : parts_.renderer->loop(), motion_.frames, result);
    if (states_.failure()) result.failures.push_back(*states_.failure());
    planner_.finish(result, own_ ? *own_->models : parts_.renderer->models());
    result.loop.device_held += tip_.faults().held;
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
    std::vector<JobResult> results;
    workers_->take_event(results);
    for (JobResult& done : results) planner_.receive(std::move(done), seconds(event.t));
    if (!results.empty()) events_.push(event.t, Kind::plan, 0);
  }

  // Returns whether another frame follows.
  bool frame(std::size_t k, double now) {
    const std::uint32_t known = planner_.known();
    if (own_)
      own_->frame(k, now, known);
    else
      tip_.read(k, Vec3::Zero());
    parts_.pipeline.pass(hip().at, known, planner_.space());
    planner_.observe(hip());
    planner_.plan(now);
    next_ = k + 1;
    if (next_ == motion_.frames) return false;
    interrupted_ = motion_.stop.is_interrupted();
    if (interrupted_) return false;
    events_.push(ns(static_cast<double>(k + 1) * motion_.clock.frame), Kind::frame, k + 1);
    if (show_ && k % 50 == 0) show_progress(k, now);
    return true;
  }

  const HipSample& hip() const { return own_ ? own_->loop.hip() : tip_.tip(); }

  void show_progress(std::size_t k, double now) const {
    const FollowingRenderer* behind = parts_.renderer;
    show_({.phase = SessionPhase::session,
           .t = now,
           .seconds = motion_.clock.seconds,
           .known = planner_.known(),
           .solved = planner_.solved(),
           .label = behind ? behind->label() : own_->models->label(),
           .force = behind ? behind->force() : own_->loop.log()[k].force.norm()});
  }

  const RunMotion& motion_;
  std::span<const Arrival> arrivals_;
  const VirtualParts& parts_;
  const ShowProgress& show_;
  EventQueue events_;
  std::shared_ptr<VirtualWorkers> workers_;
  StateLog states_;
  Planner planner_;
  TipReader tip_;                   // with a renderer that follows behind
  std::optional<OwnRenderer> own_;  // without one
  std::size_t next_ = 0;            // frame
  bool interrupted_ = false;
};

}  // namespace

void run_virtual(const RunSetup& setup, const VirtualParts& parts, SessionResult& result,
                 const ShowProgress& show) {
  VirtualRun run(setup, parts, show);
  std::exception_ptr failure;
  try {
    run.run();
  } catch (...) {
    failure = std::current_exception();
  }
  if (failure || run.interrupted()) run.end_early(setup.rendering.options.safety);
  run.finish(result);
  if (failure) result.failures.push_back(failure_in_words("planning", failure));
}

}  // namespace forefeel
