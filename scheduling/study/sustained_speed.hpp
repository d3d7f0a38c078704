#pragma once
// The highest speed that a session sustains: the largest v in [low, high] at which at least `share` of the
// frames that visit a lattice cell for the first time are within the tolerance,
//   |F - f| <= max(tolerance |f|, F_abs)
// with F the rendered force, f the reference and F_abs the floor of the JND. Each trial runs the same way,
// `travel` [m], in travel / v seconds.
//
// The search first goes down from `high` by factors of 2 until a speed holds: fast runs are short, so most of
// this scan costs little. Bisection in log v up to the last speed that failed then narrows the result to 5 %.
// The speeds tried are the same for all cells, so that cells share their reference solves.

#include <functional>

#include "scheduling/study/study.hpp"

namespace forefeel {

struct SustainedSpeed {
  double speed = 0;     // [m/s]; 0 where even `low` fails
  bool capped = false;  // `high` holds
  int trials = 0;
};

// share_at(v): share of first visits within the tolerance at speed v [m/s].
SustainedSpeed sustained_speed(const SustainedOptions& options,
                               const std::function<double(double)>& share_at);

}  // namespace forefeel
