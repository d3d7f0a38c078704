#pragma once
// The clock of a session and its duration.

namespace forefeel {

enum class Clock {
  real,         // the loop runs in real time; threads or processes solve
  virtual_time  // simulates loop and workers; same bytes on every machine
};

// When a session ends. Paths and hands never end by themselves; they run for `seconds`.
enum class RunLength {
  seconds,  // after `seconds`; the last position of a shorter motion is held
  motion,   // with the motion
  shorter   // with the motion, but after `seconds` at the latest
};

struct ClockOptions {
  Clock kind = Clock::real;
  double seconds = 20;  // [s]
  RunLength length = RunLength::seconds;
  double frame = 1e-3;  // time from frame to frame [s]
};

// Throws InputError with the key of an invalid value.
void check(const ClockOptions& options);

}  // namespace forefeel
