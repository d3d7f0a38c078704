#pragma once
// A wish to stop, by Ctrl-C (SIGINT) or SIGTERM: what runs ends at its next step and writes what it has.

#include <atomic>

namespace forefeel {

// While one lives, a first signal raises the flag; one more after a quarter of a second ends the program. Sooner
// ones are the same wish: timeout(1) signals its child and then its whole process group.
class InterruptWatch {
 public:
  InterruptWatch();   // lowers the flag
  ~InterruptWatch();  // the signals end the program again
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;

  const std::atomic<bool>& flag() const;
  bool raised() const { return flag().load(std::memory_order_relaxed); }
};

}  // namespace forefeel
