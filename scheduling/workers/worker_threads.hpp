#pragma once
// Workers of the real clock: threads of this process. Each thread that calls serve() is one worker. All calls
// share one lock, held for a few instructions.
// A thread whose solve throws is lost. The state that it was solving counts as failed, so that no other worker fails at
// it. The rest of its job is given back, and the others continue. failure() is set when the last thread is lost.

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "geometry/common/signed_vector.hpp"
#include "scheduling/workers/generator.hpp"
#include "scheduling/workers/state_solver.hpp"

namespace forefeel {

class LinearBasis;
class SolverBasis;

class WorkerThreads final : public RealWorkers {
 public:
  using Now = std::function<double()>;  // session time [s]
  WorkerThreads(std::shared_ptr<const Body> body, StateSolverOptions options, Now now = {});

  void begin(Now now) override { now_ = std::move(now); }
  bool serves() const override { return true; }
  void serve() override;
  void stop() override;

  int workers() const override;
  bool takes_jobs(int worker) const override;
  void dispatch(int worker, Job job) override;
  void cancel(int worker) override;

  void collect(std::vector<JobResult>& out, double timeout) override;
  std::exception_ptr failure() const override;
  int lost() const override;
  std::vector<std::string> notes() const override;

 private:
  struct Slot {
    std::optional<Job> job;
    std::vector<Job::Neighbour> open = {};  // of its job, without a result
    bool lost = false;
    std::stop_source stop;
    std::condition_variable wake;
  };
  void work(int worker, StateSolver& solver);
  void give(JobResult result);
  void lose(int worker, const std::exception_ptr& why);
  void give_back(int worker, SolveStatus first);
  bool all_lost() const { return failure_ && lost_.size() >= slots_.size(); }

  std::shared_ptr<SolverBasis> basis_;
  StateSolverOptions options_;
  std::shared_ptr<LinearBasis> linear_;
  Now now_;
  mutable std::mutex mutex_;
  SignedVector<Slot, std::deque<Slot>> slots_;  // references stay valid while it grows
  std::vector<JobResult> results_;
  std::condition_variable done_;
  bool stopped_ = false;
  std::exception_ptr failure_;     // the last one
  std::vector<std::string> lost_;  // a line for each thread
};

}  // namespace forefeel
