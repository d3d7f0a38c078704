#include "scheduling/touch/touch_workers.hpp"

#include <algorithm>
#include <chrono>
#include <tuple>
#include <utility>

namespace forefeel {

TouchSolved cancelled(const TouchJob& job) {
  TouchSolved solved;
  solved.state.at = job.x, solved.state.site = job.site.at;
  solved.state.solve.status = SolveStatus::cancelled;
  return solved;
}

VirtualTouchWorkers::VirtualTouchWorkers(std::shared_ptr<const RestSites> sites, double step, int count)
    : sites_(std::move(sites)), step_(step), slots_(static_cast<std::size_t>(count)) {}

std::vector<int> VirtualTouchWorkers::idle() const {
  std::vector<int> idle;
  for (std::size_t i = 0; i < slots_.size(); ++i)
    if (!slots_[i].job) idle.push_back(static_cast<int>(i));
  return idle;
}

void VirtualTouchWorkers::dispatch(int worker, TouchJob job, double now, double seconds) {
  Slot& slot = slots_[static_cast<std::size_t>(worker)];
  slot.job = job, slot.cancelled = false;
  slot.started = now, slot.finished = now + seconds;
  slot.solved = std::async(std::launch::async, [sites = sites_, step = step_, job = std::move(job)] {
    TouchSolver solver(sites, step);
    return solved_by(solver, job, {});
  });
}

void VirtualTouchWorkers::cancel(int worker, double now) {
  Slot& slot = slots_[static_cast<std::size_t>(worker)];
  slot.finished = std::min(slot.finished, now), slot.cancelled = true;
}

std::vector<TouchDone> VirtualTouchWorkers::done(double now) {
  std::vector<TouchDone> done;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    Slot& slot = slots_[i];
    if (!slot.job || slot.finished > now) continue;
    TouchSolved solved = slot.solved.get();
    done.push_back({slot.job->id, static_cast<int>(i), slot.started, slot.finished,
                    slot.cancelled ? cancelled(*slot.job) : std::move(solved)});
    slot.job.reset();
  }
  std::ranges::sort(done, {}, [](const TouchDone& d) { return std::tuple(d.finished, d.id); });
  return done;
}

RealTouchWorkers::RealTouchWorkers(std::shared_ptr<const RestSites> sites, double step, int count, Now now)
    : sites_(std::move(sites)), step_(step), now_(std::move(now)), slots_(static_cast<std::size_t>(count)) {
  for (int i = 0; i < count; ++i) threads_.emplace_back([this, i] { work(i); });
}

RealTouchWorkers::~RealTouchWorkers() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    for (Slot& slot : slots_) slot.stop.request_stop();
  }
  wake_.notify_all();
  threads_.clear();
}

std::vector<int> RealTouchWorkers::idle() {
  const std::lock_guard lock(mutex_);
  std::vector<int> idle;
  for (std::size_t i = 0; i < slots_.size(); ++i)
    if (!slots_[i].busy) idle.push_back(static_cast<int>(i));
  return idle;
}

void RealTouchWorkers::dispatch(int worker, TouchJob job) {
  {
    const std::lock_guard lock(mutex_);
    Slot& slot = slots_[static_cast<std::size_t>(worker)];
    slot.job = std::move(job);
    slot.busy = true;
    slot.stop = std::stop_source();
  }
  wake_.notify_all();
}

void RealTouchWorkers::cancel(int worker) {
  const std::lock_guard lock(mutex_);
  slots_[static_cast<std::size_t>(worker)].stop.request_stop();
}

std::vector<TouchDone> RealTouchWorkers::done(double timeout) {
  std::unique_lock lock(mutex_);
  finished_.wait_for(lock, std::chrono::duration<double>(timeout), [&] { return !results_.empty(); });
  return std::exchange(results_, {});
}

void RealTouchWorkers::work(int worker) {
  TouchSolver solver(sites_, step_);
  std::unique_lock lock(mutex_);
  Slot& slot = slots_[static_cast<std::size_t>(worker)];
  while (true) {
    wake_.wait(lock, [&] { return stopped_ || slot.job.has_value(); });
    if (stopped_) return;
    const TouchJob job = std::move(*slot.job);
    slot.job.reset();
    const std::stop_token stop = slot.stop.get_token();
    lock.unlock();
    const double started = now_();
    TouchSolved solved = solved_by(solver, job, stop);
    const double finished = now_();
    lock.lock();
    slot.busy = false;
    results_.push_back({job.id, worker, started, finished, std::move(solved)});
    finished_.notify_one();
  }
}

}  // namespace forefeel
