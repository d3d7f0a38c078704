#pragma once
// The highest speed that a session sustains: the largest v in [low, high] at which at least `share` of the
// frames that visit a lattice cell for the first time are within the tolerance,
//   |F - f| <= max(tolerance |f|, F_abs)
// with F the rendered force, f the reference and F_abs the floor of the JND (just noticeable difference). All trials
// move along the same path of length `travel` [m], in travel / v seconds.
//
// The search begins at `high` and halves the speed until the criterion holds; fast runs are short, so this takes little
// time. Bisection in log v between that speed and the last failed one then narrows the result to 5 %. All cells try
// speeds of the same set, so that they share reference solves.

#include <functional>

#include "scheduling/study/study.hpp"

namespace forefeel {

struct SustainedSpeed {
  double speed = 0;     // [m/s]; 0 if even `low` fails
  bool capped = false;  // `high` holds
  int trials = 0;
};

// share_at(v): share of first visits within the tolerance at speed v [m/s].
SustainedSpeed sustained_speed(const SustainedOptions& options,
                               const std::function<double(double)>& share_at);

}  // namespace forefeel
