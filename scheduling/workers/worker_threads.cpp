#include "scheduling/workers/worker_threads.hpp"

#include <chrono>
#include <utility>

#include "scheduling/workers/built_in_workers.hpp"
#include "scheduling/workers/solve_job.hpp"
#include "solver/equilibrium/linear_body.hpp"

namespace forefeel {

WorkerThreads::WorkerThreads(std::shared_ptr<const Body> body, StateSolverOptions options, Now now)
    : basis_(std::make_shared<SolverBasis>(std::move(body))),
      options_(std::move(options)),
      linear_(options_.sites ? nullptr : linear_basis(basis_->body(), options_.spacing)),
      now_(std::move(now)) {}

void WorkerThreads::serve() {
  int worker = -1;
  try {
    StateSolver solver(basis_, linear_, options_);
    solver.prepare();  // before it counts as a worker: the session may wait for its first state
    {
      const std::lock_guard lock(mutex_);
      if (stopped_) return;
      worker = slots_.count();
      slots_.emplace_back();
    }
    work(worker, solver);
  } catch (...) {
    lose(worker, std::current_exception());
  }
}

void WorkerThreads::work(int worker, StateSolver& solver) {
  std::unique_lock lock(mutex_);
  Slot& slot = slots_[worker];
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
}

void WorkerThreads::give(JobResult result) {
  const std::lock_guard lock(mutex_);
  std::erase_if(slots_[result.worker].open,
                [&](const Job::Neighbour& state) { return state.dispatch == result.dispatch; });
  results_.push_back(std::move(result));
  done_.notify_one();
}

void WorkerThreads::lose(int worker, const std::exception_ptr& why) {
  const std::lock_guard lock(mutex_);
  failure_ = why;
  std::string line = "a worker failed";
  try {
    std::rethrow_exception(why);
  } catch (const std::exception& problem) {
    line += std::string(": ") + problem.what();
  } catch (...) {
  }
  lost_.push_back(line + "; the others went on");
  if (worker >= 0) {
    slots_[worker].lost = true;
    give_back(worker, SolveStatus::diverged);
  }
  done_.notify_one();
}

// Under the lock: what a worker was given and has not returned; the first one with this status.
void WorkerThreads::give_back(int worker, SolveStatus first) {
  double now = 0;
  try {
    now = now_();
  } catch (...) {  // the clock itself may be what failed
  }
  for (const Job::Neighbour& state : std::exchange(slots_[worker].open, {})) {
    JobResult result;
    result.dispatch = state.dispatch;
    result.worker = worker;
    result.started = result.finished = now;
    result.state.at = state.at;
    result.state.solve.status = std::exchange(first, SolveStatus::cancelled);
    results_.push_back(std::move(result));
  }
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
  return slots_.count();
}

void WorkerThreads::dispatch(int worker, Job job) {
  const std::lock_guard lock(mutex_);
  Slot& slot = slots_[worker];
  slot.open = {{.dispatch = job.dispatch, .at = job.at}};
  slot.open.insert(slot.open.end(), job.beside.begin(), job.beside.end());
  if (slot.lost) {  // the planner did not know it yet
    give_back(worker, SolveStatus::cancelled);
    done_.notify_one();
    return;
  }
  slot.stop = std::stop_source();
  slot.job = std::move(job);
  slot.wake.notify_one();
}

void WorkerThreads::cancel(int worker) {
  const std::lock_guard lock(mutex_);
  slots_[worker].stop.request_stop();
}

void WorkerThreads::collect(std::vector<JobResult>& out, double timeout) {
  out.clear();
  std::unique_lock lock(mutex_);
  done_.wait_for(lock, std::chrono::duration<double>(timeout),
                 [&] { return !results_.empty() || all_lost(); });
  std::swap(out, results_);
}

std::exception_ptr WorkerThreads::failure() const {
  const std::lock_guard lock(mutex_);
  return all_lost() ? failure_ : nullptr;
}

bool WorkerThreads::takes_jobs(int worker) const {
  const std::lock_guard lock(mutex_);
  return !slots_[worker].lost;
}

int WorkerThreads::lost() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(lost_.size());
}

std::vector<std::string> WorkerThreads::notes() const {
  const std::lock_guard lock(mutex_);
  return lost_;
}

std::unique_ptr<RealWorkers> make_worker_threads(RealWorkersContext& context) {
  return std::make_unique<WorkerThreads>(context.body, context.solving);
}

}  // namespace forefeel
