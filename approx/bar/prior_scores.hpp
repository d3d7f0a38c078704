#pragma once
// Scores of error bars before a session has any of its own (conformal_factors.hpp): quantiles of
// sqrt(max(0, ||F - f||^2 - r^2)) / s over eight bodies, three motions and two costs of a solve, by label.
// F: rendered force, f: that of a tight solve, r: what the switch holds back, s: scale (error_scale.hpp).
// `tests/bench/error_bar_prior.py prior` measures and prints them; `check` tells how well bars cover.

#include <array>

#include "approx/bar/conformal_factors.hpp"

namespace forefeel {

std::array<PriorScores, 4> measured_prior();  // in the order of Label

}  // namespace forefeel
