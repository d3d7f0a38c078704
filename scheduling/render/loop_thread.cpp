#include "scheduling/render/loop_thread.hpp"

#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace forefeel {

namespace {

void touch_stack() {
  volatile char pages[1 << 16];
  for (std::size_t i = 0; i < sizeof pages; i += 1024) pages[i] = 0;
}

}  // namespace

std::int64_t monotonic() noexcept {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1000000000 + now.tv_nsec;
}

void sleep_until(std::int64_t t) noexcept {
  const timespec until{.tv_sec = t / 1000000000, .tv_nsec = t % 1000000000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

std::string become_loop_thread() {
  const sched_param priority{.sched_priority = 80};
  const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
  touch_stack();
  return refused == 0 ? std::string() : std::strerror(refused);
}

void become_idle_thread() noexcept {
  const sched_param none{.sched_priority = 0};
  pthread_setschedparam(pthread_self(), SCHED_IDLE, &none);
}

std::int64_t FramePacer::due(std::size_t k) const noexcept {
  return std::llround(static_cast<double>(k) * frame_ * 1e9);
}

std::size_t FramePacer::begin(std::int64_t woke) noexcept {
  std::size_t k = next_;
  if (next_ > 0) {
    const double periods = std::max(0.0, static_cast<double>(woke) / (frame_ * 1e9));
    auto newest = static_cast<std::size_t>(periods);
    while (newest > 0 && due(newest) > woke) --newest;  // rounding
    if (due(newest + 1) <= woke) ++newest;
    const std::size_t last = std::max(next_, frames_ > 0 ? frames_ - 1 : 0);
    k = std::clamp(newest, next_, next_ < frames_ ? last : std::max(next_, newest));
  }
  // Before the first wake-up, since the start.
  if (const double pause = static_cast<double>(woke - woke_) / 1e9; pause > longest_pause_) {
    longest_pause_ = pause;
    paused_at_ = static_cast<double>(woke_) / 1e9;
  }
  if (next_ < frames_) skipped_ += k - next_;
  next_ = k + 1;
  woke_ = woke;
  return k;
}

}  // namespace forefeel
