#pragma once
// A wish to stop, by Ctrl-C (SIGINT) or SIGTERM: what runs ends at its next step and writes what it has.

#include <atomic>
#include <stdexcept>
#include <string>

namespace forefeel {

// From now on signals are noted, as under a watch; for main, before commands that make a watch of their own.
void watch_from_the_start();
// A wish that was noted while there was nothing to keep: main says the text and ends with 1.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
// Throws it once a wish was noted: "interrupted before <what>: nothing was written".
void end_if_interrupted(const std::string& what);
const std::atomic<bool>& interrupt_flag();

// While one lives, a first signal raises the flag, a second one the wish to hurry, and a third ends the program. What comes
// within a quarter of a second is the same wish: timeout(1) signals its child and then its whole process group.
class InterruptWatch {
 public:
  InterruptWatch();   // lowers the flag, unless the signals were noted from the start
  ~InterruptWatch();  // the signals end the program again
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;

  const std::atomic<bool>& flag() const;
  const std::atomic<bool>& hurry() const;
  bool raised() const { return flag().load(std::memory_order_relaxed); }
};

}  // namespace forefeel
