#pragma once
// Counts the steps of the system clock (time of day): it was set, or the machine slept. A step is a change of more than
// 50 ms, between two calls of look(), in the difference of system and steady clock. The loop, the planner and the
// watchdog use only the steady clock, so a step does not affect them; the count is for the reader of a run.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>

namespace forefeel {

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

}  // namespace forefeel
