#pragma once
// A loop that only waits for its deadlines. It measures the deadlines that the machine itself misses. It has the thread
// settings (loop_thread.hpp) and the rule for late frames (loop_thread.hpp) of the session's loop, and does nothing in
// a frame. Both loops can run at the same time, under the same load, with half a frame between their deadlines.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "scheduling/common/records.hpp"

namespace forefeel {

class BareLoop {
 public:
  // frame [s]; frames: the most it runs. All memory is allocated here.
  BareLoop(double frame, std::size_t frames);
  ~BareLoop();
  BareLoop(const BareLoop&) = delete;
  BareLoop& operator=(const BareLoop&) = delete;

  // Frame 0 is due at `start` of monotonic() [ns]; only the first call counts. Any thread.
  void begin(std::int64_t start) noexcept;
  void end();  // returns when the loop has ended
  bool begun() const noexcept { return start_.load(std::memory_order_relaxed) != 0; }

  // After end(): cost and lateness of each frame until then; NaN of a frame that was skipped.
  const std::vector<FrameTiming>& frames() const { return frames_; }
  const std::string& note() const { return note_; }  // why it had no real-time priority; empty if it had one

 private:
  void run();

  double frame_;
  std::vector<FrameTiming> frames_;
  std::size_t done_ = 0;
  std::atomic<std::int64_t> start_{0};
  std::atomic<bool> ended_{false};
  std::string note_;
  std::thread thread_;
};

}  // namespace forefeel
