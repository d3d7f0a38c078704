#pragma once
// Scores of error bars until a session has its own (conformal_factors.hpp): by label, quantiles of
//   sqrt(max(0, ||F - f||^2 - r^2)) / s
// over seven bodies, three motions and two costs of a solve. F [N]: rendered force, f [N]: force of a tight solve,
// r [N]: difference between rendered and model force that the switch has not yet removed (render/bar_link.hpp), s [N]:
// scale (error_scale.hpp). `tests/bench/error_bar_prior.py prior` measures and prints them; `check` tests how well bars
// cover.

#include <array>

#include "approx/error/conformal_factors.hpp"

namespace forefeel {

std::array<PriorScores, 4> measured_prior();  // in the order of Label

}  // namespace forefeel
