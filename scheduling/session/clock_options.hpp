#pragma once
// How long a session is and by which clock.

namespace forefeel {

enum class Clock {
  real,         // the loop runs 1000 times a second, threads or processes solve
  virtual_time  // a simulation of both that gives the same bytes on every machine
};

struct ClockOptions {
  Clock kind = Clock::real;
  double seconds = 20;
  double frame = 1e-3;  // time from frame to frame [s]
};

// InputError names the key of a value that cannot be used.
void check(const ClockOptions& options);

}  // namespace forefeel
