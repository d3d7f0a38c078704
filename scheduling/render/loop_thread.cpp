#include "scheduling/render/loop_thread.hpp"

#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <cerrno>
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

}  // namespace forefeel
