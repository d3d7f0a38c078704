#pragma once
// Chooses the frame that a late loop renders next. Frame k is due at k * frame after the start. A loop that wakes late
// renders the newest frame that is due; the frames before it are skipped and counted, never rendered in a burst. Frame
// 0 and the session's last frame are always rendered. Frames after the last one belong to the ramp at the end
// (render_loop.hpp).
// All times count from the session's start on one steady clock. Nothing allocates or throws.

#include <cstddef>
#include <cstdint>

namespace forefeel {

class FramePacer {
 public:
  FramePacer(double frame, std::size_t frames) : frame_(frame), frames_(frames) {}  // frame [s]

  std::int64_t due() const noexcept { return due(next_); }  // start of the next frame [ns]
  // The loop woke at `woke` [ns], at due() or later. Returns the number of the frame to render now.
  std::size_t begin(std::int64_t woke) noexcept;
  // From the start of the frame that is rendered now to its wake-up [ns].
  std::int64_t lateness() const noexcept { return woke_ - due(next_ - 1); }

  std::size_t skipped() const noexcept { return skipped_; }
  double longest_pause() const noexcept { return longest_pause_; }  // between two wake-ups [s]
  double paused_at() const noexcept { return paused_at_; }          // when it began [s]

 private:
  std::int64_t due(std::size_t k) const noexcept;

  double frame_;
  std::size_t frames_, next_ = 0, skipped_ = 0;
  std::int64_t woke_ = 0;
  double longest_pause_ = 0, paused_at_ = 0;
};

}  // namespace forefeel
