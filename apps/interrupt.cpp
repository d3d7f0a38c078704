#include "apps/interrupt.hpp"

#include <signal.h>
#include <time.h>

#include <cstdint>

namespace forefeel {
namespace {

std::atomic<bool> wanted = false;   // lock-free: a signal handler may set them
std::atomic<std::int64_t> first = 0;   // [ns]
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free);

std::int64_t nanoseconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

extern "C" void forefeel_interrupt(int number) {
  const std::int64_t now = nanoseconds();
  std::int64_t earlier = 0;
  if (first.compare_exchange_strong(earlier, now)) {
    wanted = true;
  } else if (now - earlier > 250'000'000) {
    signal(number, SIG_DFL);
    raise(number);
  }
}

void handle(void (*handler)(int)) {
  for (const int number : {SIGINT, SIGTERM}) signal(number, handler);
}

}  // namespace

InterruptWatch::InterruptWatch() {
  wanted = false;
  first = 0;
  handle(forefeel_interrupt);
}

InterruptWatch::~InterruptWatch() { handle(SIG_DFL); }

const std::atomic<bool>& InterruptWatch::flag() const { return wanted; }

}  // namespace forefeel
