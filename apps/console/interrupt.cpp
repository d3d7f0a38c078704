#include "apps/console/interrupt.hpp"

#include <signal.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <cstdint>

namespace forefeel {
namespace {

std::atomic<bool> wanted = false, hurried = false;  // lock-free: a signal handler may set them
std::atomic<std::int64_t> last = 0;                 // [ns]
std::atomic<int> wishes = 0;
std::atomic<bool> kept = false, from_the_start = false, leave_early = false, leave_with_json = false;
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free &&
              std::atomic<int>::is_always_lock_free);

std::int64_t nanoseconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

// Until a command creates its own InterruptWatch, nothing has to be saved. If end_if_interrupted() is not called within
// half a second (a large lattice, a surface being meshed), the program exits at once.
extern "C" void forefeel_leave(int) {
  if (!from_the_start) return;
  static constexpr char nothing[] = "forefeel: interrupted before the work began: nothing was written\n";
  static constexpr char pieces[] =
      "forefeel: interrupted before the work began: what was made for it is kept, and a rerun resumes\n";
  static constexpr char document[] = "{\n  \"interrupted\": true\n}\n";
  ssize_t written = leave_with_json ? write(STDOUT_FILENO, document, sizeof document - 1) : 0;
  written += kept ? write(STDERR_FILENO, pieces, sizeof pieces - 1)
                  : write(STDERR_FILENO, nothing, sizeof nothing - 1);
  static_cast<void>(written);
  _exit(1);
}

void leave_soon(std::int64_t microseconds) {
  itimerval timer{};
  timer.it_value.tv_usec = static_cast<suseconds_t>(microseconds);
  setitimer(ITIMER_REAL, &timer, nullptr);
}

extern "C" void forefeel_interrupt(int number) {
  const std::int64_t now = nanoseconds();
  std::int64_t before = last;
  if ((before != 0 && now - before < 250'000'000) || !last.compare_exchange_strong(before, now)) return;
  const int wish = ++wishes;
  wanted = true;
  if (wish == 2) hurried = true;
  if (wish == 1 && from_the_start && leave_early) leave_soon(500'000);
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

void pieces_are_kept() {
  kept = true;
}

void watch_from_the_start(const EarlyInterrupt& early) {
  from_the_start = true;
  leave_early = early.leave;
  leave_with_json = early.json;
  signal(SIGALRM, forefeel_leave);
  handle(forefeel_interrupt);
}

void end_if_interrupted(const std::string& what) {
  if (wanted) throw Interrupted("interrupted before " + what + ": nothing was written");
}

const std::atomic<bool>& interrupt_flag() {
  return wanted;
}

InterruptWatch::InterruptWatch() {
  if (from_the_start.exchange(false)) {
    leave_soon(0);  // from here on the command saves what it has
    return;
  }
  wanted = hurried = false;
  last = 0;
  wishes = 0;
  handle(forefeel_interrupt);
}

InterruptWatch::~InterruptWatch() {
  handle(SIG_DFL);
}

const std::atomic<bool>& InterruptWatch::flag() const {
  return wanted;
}
const std::atomic<bool>& InterruptWatch::hurry() const {
  return hurried;
}

}  // namespace forefeel
