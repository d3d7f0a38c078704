#include "scheduling/worker_threads.hpp"

#include <chrono>

namespace forefeel {

WorkerThreads::WorkerThreads(std::shared_ptr<const Body> body, StateSolverOptions options, Now now)
    : body_(std::move(body)), options_(options), linear_(linear_basis(body_, options.spacing)), now_(std::move(now)) {}

void WorkerThreads::serve() {
  int worker = -1;
  try {
    StateSolver solver(body_, linear_, options_);
    std::unique_lock lock(mutex_);
    if (stopped_) return;
    worker = static_cast<int>(slots_.size());
    Slot& slot = slots_.emplace_back();
    for (;;) {
      slot.wake.wait(lock, [&] { return stopped_ || slot.job; });
      if (stopped_) return;
      const Job job = std::move(*slot.job);
      slot.job.reset();
      const std::stop_token stop = slot.stop.get_token();
      lock.unlock();
      JobResult result = run(solver, worker, job, stop);
      lock.lock();
      results_.push_back(std::move(result));
      done_.notify_one();
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
    done_.notify_one();
  }
}

JobResult WorkerThreads::run(StateSolver& solver, int worker, const Job& job, std::stop_token stop) {
  JobResult result{.dispatch = job.dispatch, .worker = worker, .started = now_(), .state = {}, .equilibrium = nullptr};
  SolveOutcome outcome = solver.from(job.start.get(), job.at, stop);
  result.finished = now_();
  result.state = std::move(outcome.state);
  result.state.at = job.at;
  result.equilibrium = std::move(outcome.equilibrium);
  return result;
}

void WorkerThreads::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  for (Slot& slot : slots_) {
    slot.stop.request_stop();
    slot.wake.notify_one();
  }
}

int WorkerThreads::workers() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(slots_.size());
}

void WorkerThreads::dispatch(int worker, Job job) {
  const std::lock_guard lock(mutex_);
  Slot& slot = slots_[static_cast<std::size_t>(worker)];
  slot.stop = std::stop_source();
  slot.job = std::move(job);
  slot.wake.notify_one();
}

void WorkerThreads::cancel(int worker) {
  const std::lock_guard lock(mutex_);
  slots_[static_cast<std::size_t>(worker)].stop.request_stop();
}

void WorkerThreads::collect(std::vector<JobResult>& out, double timeout) {
  out.clear();
  std::unique_lock lock(mutex_);
  done_.wait_for(lock, std::chrono::duration<double>(timeout), [&] { return !results_.empty() || failure_; });
  std::swap(out, results_);
}

std::exception_ptr WorkerThreads::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

}  // namespace forefeel
