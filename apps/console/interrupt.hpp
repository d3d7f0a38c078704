#pragma once
// Ctrl-C (SIGINT) and SIGTERM ask a command to stop: it ends at its next step and writes what it has.

#include <atomic>
#include <stdexcept>
#include <string>

namespace forefeel {

// From now on signals are noted, as under an InterruptWatch. Called by main before commands that make one
// later.
void watch_from_the_start();
// Interrupted before anything could be saved. main prints the text and exits with 1.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
// Throws Interrupted if a signal was noted: "interrupted before <what>: nothing was written".
void end_if_interrupted(const std::string& what);
const std::atomic<bool>& interrupt_flag();

// While one lives, the first signal raises flag(), the second hurry(), and the third ends the program.
// Signals within a quarter of a second count as one: timeout(1) signals its child and then its whole process
// group.
class InterruptWatch {
 public:
  InterruptWatch();   // lowers the flag, unless the signals were noted from the start
  ~InterruptWatch();  // from then on a signal ends the program
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;

  const std::atomic<bool>& flag() const;
  const std::atomic<bool>& hurry() const;
  bool raised() const { return flag().load(std::memory_order_relaxed); }
};

}  // namespace forefeel
