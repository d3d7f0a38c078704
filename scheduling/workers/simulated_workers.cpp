// Workers of the virtual clock. A job reaches its worker after one message time (the latency). Each of its
// states takes the time of the cost model, a neighbour of the first one a share of it; the result arrives one
// message time later. A cancellation that arrives in time releases the worker two message times after it was
// sent; a later solve of that state resumes the work. The values are those of the reference branch. Real
// threads solve them from the moment of dispatch; their speed affects the wall time only.

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <tuple>

#include "geometry/common/signed_vector.hpp"
#include "scheduling/workers/built_in_workers.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/generator.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {
namespace {

using Time = VirtualWorkers::Time;

constexpr double without_end =
    1e8;  // [s], three years: no run is longer, and sums of a few such times still fit

Time time_of(double seconds) {
  return Time(std::llround(std::min(seconds, without_end) * 1e9));
}
double seconds_of(Time t) {
  return static_cast<double>(t.count()) / 1e9;
}

class SimulatedWorkers final : public VirtualWorkers {
 public:
  explicit SimulatedWorkers(const VirtualWorkersContext& with)
      : with_(with), latency_(time_of(with.latency)), running_(static_cast<std::size_t>(with.count)) {}

  int workers() const override { return running_.count(); }
  void set_now(Time now) override { now_ = now; }

  void dispatch(int worker, Job job) override {
    std::vector<Solve>& solves = running_[worker];
    solves.clear();
    Time begin = add(solves, worker, job.dispatch, {job.at, job.site}, 1, now_ + latency_);
    for (const Job::Neighbour& neighbour : job.beside)
      begin = add(solves, worker, neighbour.dispatch, {neighbour.at, job.site}, with_.batch_share, begin);
  }

  void cancel(int worker) override {
    const Time arrives = now_ + latency_;
    bool any = false;
    for (Solve& solve : running_[worker]) {
      if (solve.returned || arrives >= solve.finished) continue;  // solved before the message arrives
      if (arrives > solve.started) done_[solve.place] += arrives - solve.started;
      solve.cancelled = any = true;
      solve.started = std::min(solve.started, arrives);
      solve.finished = arrives;
      solve.due = arrives + latency_;
    }
    if (any) events_.push({arrives + latency_, sequence_++, worker});
  }

  std::optional<Time> next_event() const override {
    if (events_.empty()) return {};
    return events_.top().t;
  }

  void take_event(std::vector<JobResult>& results) override {
    const Event event = events_.top();
    events_.pop();
    results.clear();
    for (Solve& solve : running_[event.worker]) {
      if (solve.returned || solve.due != event.t) continue;
      solve.returned = true;
      JobResult& result = results.emplace_back();
      result.dispatch = solve.dispatch;
      result.worker = event.worker;
      result.started = seconds_of(solve.started);
      result.finished = seconds_of(solve.finished);
      if (solve.cancelled)
        result.state.solve.status = SolveStatus::cancelled;
      else
        result.state = with_.references.get(solve.place.x, solve.place.site);
    }
  }

 private:
  struct Place {
    Vec3 x = Vec3::Zero();
    SurfacePlace site = {};
  };
  struct Solve {
    std::uint32_t dispatch = 0;
    Place place = {};
    Time started{}, finished{}, due{};
    bool cancelled = false, returned = false;
  };
  struct Event {
    Time t{};
    std::uint64_t sequence = 0;
    int worker = 0;
    friend bool operator>(const Event& a, const Event& b) {
      return std::tie(a.t, a.sequence) > std::tie(b.t, b.sequence);
    }
  };
  struct ByPlace {
    bool operator()(const Place& a, const Place& b) const {
      const auto key = [](const Place& p) {
        return std::tie(p.x[0], p.x[1], p.x[2], p.site.at[0], p.site.at[1], p.site.at[2]);
      };
      return key(a) < key(b);
    }
  };

  // Places of a body that is touched anywhere cost what the place of the tip does.
  Time add(std::vector<Solve>& solves, int worker, std::uint32_t dispatch, const Place& place, double share,
           Time begin) {
    Time cost = time_of(share * (with_.rest_first && place.x.isZero(0)
                                     ? checked_rest_seconds(with_.cost)
                                     : checked_seconds(with_.cost, place.site.at + place.x)));
    if (const auto done = done_.find(place); done != done_.end()) cost -= done->second;
    const Time end = begin + std::max(Time(1), cost);
    solves.push_back(
        {.dispatch = dispatch, .place = place, .started = begin, .finished = end, .due = end + latency_});
    with_.references.request(place.x, place.site);
    events_.push({end + latency_, sequence_++, worker});
    return end;
  }

  const VirtualWorkersContext with_;
  Time latency_, now_{};
  SignedVector<std::vector<Solve>> running_;
  std::map<Place, Time, ByPlace> done_;  // time already spent on states whose solve was cancelled
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::uint64_t sequence_ = 0;
};

}  // namespace

std::unique_ptr<VirtualWorkers> make_simulated_workers(VirtualWorkersContext& context) {
  return std::make_unique<SimulatedWorkers>(context);
}

}  // namespace forefeel
