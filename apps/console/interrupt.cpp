#include "apps/console/interrupt.hpp"

#include <signal.h>
#include <time.h>

#include <cstdint>

namespace forefeel {
namespace {

std::atomic<bool> wanted = false, hurried = false;  // lock-free: a signal handler may set them
std::atomic<std::int64_t> last = 0;                 // [ns]
std::atomic<int> wishes = 0;
bool from_the_start = false;
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free &&
              std::atomic<int>::is_always_lock_free);

std::int64_t nanoseconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

extern "C" void forefeel_interrupt(int number) {
  const std::int64_t now = nanoseconds();
  std::int64_t before = last;
  if ((before != 0 && now - before < 250'000'000) || !last.compare_exchange_strong(before, now)) return;
  const int wish = ++wishes;
  wanted = true;
  if (wish == 2) hurried = true;
  if (wish < 3) return;
  signal(number, SIG_DFL);
  raise(number);
}

void handle(void (*handler)(int)) {
  for (const int number : {SIGINT, SIGTERM}) signal(number, handler);
  if (signal(SIGHUP, handler) == SIG_IGN) signal(SIGHUP, SIG_IGN);
}

}  // namespace

void write_errors_without_signals() {
  for (const int number : {SIGPIPE, SIGXFSZ}) signal(number, SIG_IGN);
}

void watch_from_the_start() {
  from_the_start = true;
  handle(forefeel_interrupt);
}

void end_if_interrupted(const std::string& what) {
  if (wanted) throw Interrupted("interrupted before " + what + ": nothing was written");
}

const std::atomic<bool>& interrupt_flag() {
  return wanted;
}

InterruptWatch::InterruptWatch() {
  if (from_the_start) return;
  wanted = hurried = false;
  last = 0;
  wishes = 0;
  handle(forefeel_interrupt);
}

InterruptWatch::~InterruptWatch() {
  handle(SIG_DFL);
  from_the_start = false;
}

const std::atomic<bool>& InterruptWatch::flag() const {
  return wanted;
}
const std::atomic<bool>& InterruptWatch::hurry() const {
  return hurried;
}

}  // namespace forefeel
