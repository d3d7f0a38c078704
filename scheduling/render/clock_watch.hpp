#pragma once
// Counts the steps of the clock of the day: times at which it was set, or at which the machine slept. A step is a
// change by more than 50 ms of the time of day less the time of the steady clock, between two looks. The loop, the
// planner and the watchdog use the steady clock alone, which no setting moves; the count tells the reader of a run.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>

namespace forefeel {

class ClockWatch {
 public:
  static constexpr std::int64_t least = 50'000'000;  // [ns]

  // Both read at the same moment [ns].
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
