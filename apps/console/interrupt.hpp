#pragma once
// Ctrl-C (SIGINT), SIGTERM and SIGHUP (the terminal is gone) ask a command to stop. It finishes its current step and
// writes its results so far. If SIGHUP was ignored at the start, as under nohup, it is still ignored.
// SIGPIPE and SIGXFSZ are ignored: writing to a pipe without a reader, or beyond the size limit of a file, then fails
// with an error (EPIPE, EFBIG) instead of silently ending the program.

#include <atomic>
#include <stdexcept>
#include <string>

namespace forefeel {

// Writes that fail return an error instead of a signal. main calls it first.
void write_errors_without_signals();

// Starts to record signals, as an InterruptWatch does. main calls it before commands that create their
// InterruptWatch later.
struct EarlyInterrupt {
  bool leave = true;  // until then, a signal not handled within half a second ends the program with code 1
  bool json = false;  // and prints {"interrupted": true}
};
void watch_from_the_start(const EarlyInterrupt& early);
// From now on pieces of what is being made are kept as they come, and the line of such an end says so.
void pieces_are_kept();
// Interrupted before anything could be saved. main prints the text and exits with 1.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
// Throws Interrupted if a signal was recorded: "interrupted before <what>: nothing was written".
void end_if_interrupted(const std::string& what);
const std::atomic<bool>& interrupt_flag();

// While an object lives, the first signal sets flag(), the second sets hurry(), and the third ends the
// program. Signals within a quarter of a second count as one, because timeout(1) signals its child and then
// the whole process group.
class InterruptWatch {
 public:
  InterruptWatch();   // clears the flag, unless signals were recorded from the start
  ~InterruptWatch();  // afterwards a signal ends the program again
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;

  const std::atomic<bool>& flag() const;
  const std::atomic<bool>& hurry() const;
  bool raised() const { return flag().load(std::memory_order_relaxed); }
};

}  // namespace forefeel
