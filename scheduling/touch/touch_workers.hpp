#pragma once
// The workers of a touch session. Virtual: a solve ends after the time that the cost model says; it is computed by a
// thread meanwhile, and its result depends on the job alone. Real: threads that wait for a job.

#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
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
  std::vector<TouchDone> done(double now);  // of solves that end by now, in their order

 private:
  struct Slot {
    std::optional<TouchJob> job;
    double started = 0, finished = 0;
    std::future<TouchSolved> solved;
  };
  std::shared_ptr<const RestSites> sites_;
  double step_;
  std::vector<Slot> slots_;
};

class RealTouchWorkers {
 public:
  using Now = std::function<double()>;  // session time [s]
  RealTouchWorkers(std::shared_ptr<const RestSites> sites, double step, int count, Now now);
  ~RealTouchWorkers();  // waits for what is being solved, which is told to stop
  std::vector<int> idle();
  void dispatch(int worker, TouchJob job);
  void cancel(int worker);
  // What is done, after waiting up to this time for it [s].
  std::vector<TouchDone> done(double timeout);

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
