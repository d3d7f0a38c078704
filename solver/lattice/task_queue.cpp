#include "solver/lattice/task_queue.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

namespace forefeel {
double wall_seconds(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

TaskQueue::TaskQueue(std::vector<SweepPiece> pieces)
    : pieces_(std::move(pieces)), at_(pieces_.size()), left_(pieces_.size()) {
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    if (pieces_[i].waits_for == 0) ready_.push({.piece = i});
}

// Processor time of the parts that this thread runs, and of the longest of them. A clock of the processor's own for
// each part would cost as much as a small part does, so the sum is divided as the wall time is.
TaskQueue::Share::Times TaskQueue::Share::run() {
  const double start = thread_seconds();
  double most = 0, sum = 0;
  for (std::size_t i = next++; i < count; i = next++) {
    const auto begun = std::chrono::steady_clock::now();
    part(i);
    const double seconds = wall_seconds(begun);
    most = std::max(most, seconds);
    sum += seconds;
  }
  const double all = thread_seconds() - start;
  return {all, sum > 0 ? all * most / sum : 0};
}

TaskQueue::Share* TaskQueue::open_share() {
  const auto open = std::ranges::find_if(shares_, [](const Share* s) { return s->next < s->count; });
  return open == shares_.end() ? nullptr : *open;
}

void TaskQueue::help(Share& share, std::unique_lock<std::mutex>& lock) {
  ++share.helpers;
  lock.unlock();
  const Share::Times its = share.run();
  lock.lock();
  share.longest = std::max(share.longest, its.longest);
  times_.work += its.all;
  times_.idle -= its.all;
  if (--share.helpers == 0) changed_.notify_all();
}

void TaskQueue::Member::share(std::size_t count, const std::function<void(std::size_t)>& part) {
  Share share{part, count};
  const bool with_others = queue_.free_ > 0;
  if (with_others) {
    const std::lock_guard lock(queue_.mutex_);
    queue_.shares_.push_back(&share);
    queue_.changed_.notify_all();
  }
  const Share::Times its = share.run();
  shared_ += its.all;
  double most = its.longest;
  if (with_others) {
    std::unique_lock lock(queue_.mutex_);
    std::erase(queue_.shares_, &share);
    queue_.changed_.wait(lock, [&] { return share.helpers == 0; });
    most = std::max(most, share.longest);
  }
  longest_ += most;
}

std::optional<LatticeTask> TaskQueue::take(const std::function<bool()>& stopped) {
  std::unique_lock lock(mutex_);
  const auto start = std::chrono::steady_clock::now();
  ++free_;
  while (ready_.empty() && left_ > 0 && !stopped()) {
    if (Share* const share = open_share())
      help(*share, lock);
    else
      changed_.wait(lock);
  }
  --free_;
  times_.idle += wall_seconds(start);
  if (ready_.empty() || stopped()) return {};
  const LatticeTask task = ready_.top();
  ready_.pop();
  return task;
}

void TaskQueue::done(const LatticeTask& task, double seconds, Member& by, const NextTasks& next) {
  const std::lock_guard lock(mutex_);
  times_.work += seconds;
  Progress& at = at_[task.piece];
  at.end =
      std::max(at.end, task.begins + seconds - std::exchange(by.shared_, 0) + std::exchange(by.longest_, 0));
  times_.path = std::max(times_.path, at.end);
  if (at.open > 1) {
    --at.open;
    return;
  }
  at.open = next.count;
  for (std::size_t place = 0; place < next.count; ++place)
    ready_.push({task.piece, next.step, place, at.end, next.cell});
  if (next.count == 0) finish(task.piece, at.end);
  changed_.notify_all();
}

void TaskQueue::wake() {
  const std::lock_guard lock(mutex_);
  changed_.notify_all();
}

ParallelTimes TaskQueue::times(double before, double in_sink) const {
  return {.work = before + times_.work, .path = before + std::max(times_.path, in_sink), .idle = times_.idle};
}

void TaskQueue::finish(std::size_t id, double end) {
  --left_;
  for (const std::size_t other : pieces_[id].before) {
    at_[other].end = std::max(at_[other].end, end);
    if (--pieces_[other].waits_for == 0) ready_.push({.piece = other, .begins = at_[other].end});
  }
}

}  // namespace forefeel
