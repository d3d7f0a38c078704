#pragma once
// How a session is ended from outside.

#include <atomic>

namespace forefeel {

struct StopOptions {
  const std::atomic<bool>* interrupted = nullptr;  // once true, the session ends after that frame
  const std::atomic<bool>* hurried =
      nullptr;          // once true, an interrupted session waits for no reference any more
  double patience = 3;  // how long an interrupted session waits for references that are not solved yet [s]

  bool is_interrupted() const { return interrupted && interrupted->load(std::memory_order_relaxed); }
  bool is_hurried() const { return hurried && hurried->load(std::memory_order_relaxed); }
};

}  // namespace forefeel
