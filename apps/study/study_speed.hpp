#pragma once
// The highest speed that a session sustains: the largest v in [low, high] at which at least `share` of the
// frames that visit a lattice cell for the first time are within `tolerance` of the reference, |F - f| <=
// tolerance |f| with the floor F_abs of the JND. Each trial runs the same way, `travel` [m], in travel / v
// seconds. A coarse scan downward from `high` by factors of 2 ends at the first speed that holds: fast runs are short,
// so that most of the scan costs little. Bisection in log v up to the one above then narrows it to 5 %. The speeds
// tried lie on one grid whatever is found, so that cells share their reference solves.

#include <functional>

#include "apps/study/study.hpp"

namespace forefeel {

struct SustainedSpeed {
  double speed = 0;     // [m/s]; 0 where even `low` fails
  bool capped = false;  // `high` holds
  int trials = 0;
};

// share_at(v): share of first visits within the tolerance at speed v.
SustainedSpeed sustained_speed(const SustainedOptions& options,
                               const std::function<double(double)>& share_at);

}  // namespace forefeel
