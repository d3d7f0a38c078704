#pragma once
// How long a session is and by which clock.

namespace forefeel {

enum class Clock {
  real,         // the loop runs 1000 times a second, threads or processes solve
  virtual_time  // a simulation of both that gives the same bytes on every machine
};

// Where a session ends. Paths and hands have no end; they run for `seconds`.
enum class RunLength {
  seconds,  // after `seconds`; a motion that ends before is held
  motion,   // with the motion
  shorter   // with the motion, but after `seconds` at the latest
};

struct ClockOptions {
  Clock kind = Clock::real;
  double seconds = 20;
  RunLength length = RunLength::seconds;
  double frame = 1e-3;  // time from frame to frame [s]
};

// InputError names the key of a value that cannot be used.
void check(const ClockOptions& options);

}  // namespace forefeel
