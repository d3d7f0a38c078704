#pragma once
// The workers of a touch session. Virtual: a solve ends after the time that the cost model says; it is computed by a
// thread meanwhile, and its result depends on the job alone. Real: threads that wait for a job, or
// other processes (touch_ranks.hpp).

#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "scheduling/touch/touch_solver.hpp"

namespace forefeel {

struct TouchDone {
  std::uint32_t id = 0;
  int worker = 0;
  double started = 0, finished = 0;  // session time [s]
  TouchSolved solved;
};

class VirtualTouchWorkers {
 public:
  VirtualTouchWorkers(std::shared_ptr<const RestSites> sites, double step, int count);
  std::vector<int> idle() const;
  void dispatch(int worker, TouchJob job, double now, double seconds);
  void cancel(int worker, double now);
  std::vector<TouchDone> done(double now);  // of solves that end by now, in their order

 private:
  struct Slot {
    std::optional<TouchJob> job;
    double started = 0, finished = 0;
    std::future<TouchSolved> solved;
    bool cancelled = false;
  };
  std::shared_ptr<const RestSites> sites_;
  double step_;
  std::vector<Slot> slots_;
};

TouchSolved cancelled(const TouchJob& job);

// Of a session under the real clock; one thread uses them.
class TouchWorkers {
 public:
  virtual ~TouchWorkers() = default;
  virtual std::vector<int> idle() = 0;
  virtual void dispatch(int worker, TouchJob job) = 0;
  virtual void cancel(int worker) = 0;
  // What is done, after waiting up to this time for it [s].
  virtual std::vector<TouchDone> done(double timeout) = 0;
  virtual std::vector<std::string> notes() const { return {}; }
};

class RealTouchWorkers final : public TouchWorkers {
 public:
  using Now = std::function<double()>;  // session time [s]
  RealTouchWorkers(std::shared_ptr<const RestSites> sites, double step, int count, Now now);
  ~RealTouchWorkers() override;  // waits for what is being solved, which is told to stop
  std::vector<int> idle() override;
  void dispatch(int worker, TouchJob job) override;
  void cancel(int worker) override;
  std::vector<TouchDone> done(double timeout) override;

 private:
  struct Slot {
    std::optional<TouchJob> job;
    bool busy = false;
    std::stop_source stop;
  };
  void work(int worker);

  std::shared_ptr<const RestSites> sites_;
  double step_;
  Now now_;
  std::mutex mutex_;
  std::condition_variable wake_, finished_;
  bool stopped_ = false;
  std::deque<Slot> slots_;
  std::vector<TouchDone> results_;
  std::vector<std::jthread> threads_;
};

}  // namespace forefeel
