#pragma once
// How a session is stopped from outside.

#include <atomic>

namespace forefeel {

struct StopOptions {
  const std::atomic<bool>* interrupted = nullptr;  // once true, the session ends after that frame
  // Once true, an interrupted session no longer waits for references.
  const std::atomic<bool>* hurried = nullptr;
  double patience = 3;  // an interrupted session waits this long for pending references [s]

  bool is_interrupted() const { return interrupted && interrupted->load(std::memory_order_relaxed); }
  bool is_hurried() const { return hurried && hurried->load(std::memory_order_relaxed); }
};

}  // namespace forefeel
