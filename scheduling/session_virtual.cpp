// Virtual clock: a discrete-event simulation of the planner and loop. Time is integer nanoseconds; events are in a
// total order (time, kind, sequence): results first, then planning, then the frame of that instant. State values are
// the reference branch's, solved on real threads from the moment they are dispatched: how long that takes changes
// nothing but the wait.

#include <cmath>
#include <queue>
#include <tuple>

#include "scheduling/session_parts.hpp"

namespace forefeel {
namespace {

using Nanoseconds = std::int64_t;
Nanoseconds ns(double seconds) { return std::llround(seconds * 1e9); }
double seconds(Nanoseconds t) { return static_cast<double>(t) / 1e9; }

enum class Kind { result, arrival, plan, frame };

struct Event {
  Nanoseconds t = 0;
  Kind kind = Kind::frame;
  std::uint64_t sequence = 0;
  std::uint64_t payload = 0;   // worker, arrival or frame

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

// Simulated workers: a job reaches them a message later, takes what the cost model says, and its result comes a
// message after that. A cancellation that arrives in time gives the worker back two messages after it was sent.
class SimulatedWorkers final : public Generator {
 public:
  SimulatedWorkers(int workers, const CostModel& cost, double latency, ReferenceService& references, EventQueue& events)
      : cost_(cost), latency_(ns(latency)), references_(references), events_(events), running_(static_cast<std::size_t>(workers)) {}

  void set_now(Nanoseconds now) { now_ = now; }
  int workers() const override { return static_cast<int>(running_.size()); }

  void dispatch(int worker, Job job) override {
    Running& run = running_[static_cast<std::size_t>(worker)];
    run.started = now_ + latency_;
    run.finished = run.started + std::max<Nanoseconds>(1, ns(cost_.seconds(job.at)));
    run.cancelled = false;
    run.due = run.finished + latency_;
    references_.request(job.at);
    run.job = std::move(job);
    events_.push(run.due, Kind::result, static_cast<std::uint64_t>(worker));
  }

  void cancel(int worker) override {
    Running& run = running_[static_cast<std::size_t>(worker)];
    if (now_ + latency_ >= run.finished) return;   // solved before the message arrives
    run.cancelled = true;
    run.finished = std::max(run.started, now_ + latency_);
    run.due = run.finished + latency_;
    events_.push(run.due, Kind::result, static_cast<std::uint64_t>(worker));
  }

  // Null for the event of a job that was cancelled before.
  std::optional<JobResult> take(const Event& event) {
    Running& run = running_[event.payload];
    if (event.t != run.due || run.due == 0) return std::nullopt;
    run.due = 0;
    JobResult result{.dispatch = run.job.dispatch,
                     .worker = static_cast<int>(event.payload),
                     .started = seconds(run.started),
                     .finished = seconds(run.finished),
                     .state = {},
                     .equilibrium = nullptr};
    if (run.cancelled)
      result.state.status = SolveStatus::cancelled;
    else
      result.state = references_.get(run.job.at);
    return result;
  }

 private:
  struct Running {
    Job job;
    Nanoseconds started = 0, finished = 0, due = 0;
    bool cancelled = false;
  };
  const CostModel& cost_;
  Nanoseconds latency_, now_ = 0;
  ReferenceService& references_;
  EventQueue& events_;
  std::vector<Running> running_;
};

}  // namespace

void run_virtual(SessionPlan& plan, ReferenceService& references, SessionResult& result, const ShowProgress& show) {
  const SessionOptions& options = plan.options;
  EventQueue events;
  LoopLink link;
  SimulatedWorkers workers(plan.given_arrivals ? 0 : options.workers, *plan.cost, options.latency, references, events);
  std::unique_ptr<StateWriter> writer;
  if (plan.input.state_file)
    writer = std::make_unique<StateWriter>(StateFile::open_or_create(
        *plan.input.state_file,
        {.identity = plan.input.identity, .spacing = plan.input.space.spacing, .box = plan.input.space.box, .notes = {}}));
  Planner planner(plan.input, options, workers, link, hooks_of(plan, writer.get()));
  RenderLoop loop(*plan.device, link, options, plan.frames);

  for (std::size_t i = 0; i < plan.arrivals.size(); ++i) {
    if (plan.arrivals[i].t > options.seconds) break;
    references.request(plan.arrivals[i].at);
    events.push(ns(plan.arrivals[i].t), Kind::arrival, i);
  }
  events.push(0, Kind::frame, 0);
  while (!events.empty()) {
    const Event event = events.pop();
    const double now = seconds(event.t);
    workers.set_now(event.t);
    if (event.kind == Kind::result) {
      if (auto done = workers.take(event)) {
        planner.receive(std::move(*done), now);
        events.push(event.t, Kind::plan, 0);
      }
    } else if (event.kind == Kind::arrival) {
      planner.arrive(references.get(plan.arrivals[event.payload].at), now);
    } else if (event.kind == Kind::plan) {
      planner.plan(now);
    } else {
      // A model made now is rendered now: states and motion up to this instant, at most one update a frame.
      planner.update(now);
      link.planner_beat.store(now, std::memory_order_relaxed);
      loop.frame(event.payload);
      planner.observe(*link.hip.take());
      planner.plan(now);
      const std::size_t next = event.payload + 1;
      if (next == plan.frames || (options.interrupted && options.interrupted->load(std::memory_order_relaxed))) break;
      events.push(ns(static_cast<double>(next) * options.frame), Kind::frame, next);
      if (show && next % 250 == 0)
        show({.t = now, .seconds = options.seconds, .known = planner.space().size(), .solved = planner.solved(),
              .label = planner.label(), .force = loop.log()[event.payload].force.norm(), .phase = "session"});
    }
  }
  if (writer) writer->flush();
  take_loop(loop, plan.frames, result);
  planner.finish(result);
  result.workers = workers.workers();
}

}  // namespace forefeel
