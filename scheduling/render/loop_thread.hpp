#pragma once
// The thread of a real-time loop: its priority, its stack and its clock. The session's loop and the bare loop to which
// it is compared (bare_loop.hpp) share these settings.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>

namespace forefeel {

// CLOCK_MONOTONIC [ns]. Neither allocates nor throws.
std::int64_t monotonic() noexcept;
// Returns at the absolute time t of that clock [ns] or later.
void sleep_until(std::int64_t t) noexcept;

// Gives the calling thread real-time priority (SCHED_FIFO, 80) and touches 64 kB of its stack, so that a loop causes no
// page fault there. If the priority is refused, returns why; else an empty text.
std::string become_loop_thread();
// Lets the calling thread run only on processors that are otherwise idle (SCHED_IDLE).
void become_idle_thread() noexcept;

// Counts the steps of the system clock (time of day): it was set, or the machine slept. A step is a change of more than
// 50 ms, between two calls of look(), in the difference of system and steady clock. The loop, the planner and the
// watchdog use only the steady clock, so a step does not affect them; the count is for the reader of a run.

class ClockWatch {
 public:
  static constexpr std::int64_t least = 50'000'000;  // [ns]

  // steady, of_day: both clocks, read at the same moment [ns].
  void look(std::int64_t steady, std::int64_t of_day) noexcept {
    const std::int64_t ahead = of_day - steady;
    if (ahead_ && std::abs(ahead - *ahead_) > least) ++steps_;
    ahead_ = ahead;
  }
  std::size_t steps() const noexcept { return steps_; }

 private:
  std::optional<std::int64_t> ahead_;
  std::size_t steps_ = 0;
};

// Chooses the frame that a late loop renders next. Frame k is due at k * frame after the start. A loop that wakes late
// renders the newest frame that is due; the frames before it are skipped and counted, never rendered in a burst. Frame
// 0 and the session's last frame are always rendered. Frames after the last one belong to the ramp at the end
// (render_loop.hpp).
// All times count from the session's start on one steady clock. Nothing allocates or throws.

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
