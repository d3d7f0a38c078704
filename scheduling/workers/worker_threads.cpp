#include "scheduling/workers/worker_threads.hpp"

#include <chrono>

#include "scheduling/workers/built_in_workers.hpp"
#include "scheduling/workers/solve_job.hpp"

namespace forefeel {

WorkerThreads::WorkerThreads(std::shared_ptr<const Body> body, StateSolverOptions options, Now now)
    : basis_(std::make_shared<SolverBasis>(std::move(body))),
      options_(options),
      linear_(linear_basis(basis_->body(), options.spacing)),
      now_(std::move(now)) {}

void WorkerThreads::serve() {
  int worker = -1;
  try {
    StateSolver solver(basis_, linear_, options_);
    solver.prepare();  // before it counts as a worker: the session may wait for its first state
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
      solve_job(solver, job, stop, now_, [&](JobResult result) {
        result.worker = worker;
        give(std::move(result));
      });
      lock.lock();
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
    done_.notify_one();
  }
}

void WorkerThreads::give(JobResult result) {
  const std::lock_guard lock(mutex_);
  results_.push_back(std::move(result));
  done_.notify_one();
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

std::unique_ptr<RealWorkers> make_worker_threads(RealWorkersContext& context) {
  return std::make_unique<WorkerThreads>(context.body, context.solving);
}

}  // namespace forefeel
