#pragma once
// Scores of error bars until a session has its own (conformal_factors.hpp): by label, quantiles of
//   sqrt(max(0, ||F - f||^2 - r^2)) / s
// over the samples of 23 sessions whose bar of 95 % was above its floor: bodies, laws, contacts, motions and costs of a
// solve were drawn at random for most of them. F [N]: rendered force, f [N]: force of a tight solve,
// r [N]: difference between rendered and model force that the switch has not yet removed (render/bar_link.hpp), s [N]:
// scale (error_scale.hpp, bar_keeper.hpp). `tests/bench/error_bar_prior.py prior` prints them; `check` tests how well
// bars cover in other sessions. Left out in turn, each of the 23 sessions judged by the others: bars of 90, 95 and
// 99 % held 89, 94 and 98 % above the floor.

#include <array>

#include "approx/error/conformal_factors.hpp"

namespace forefeel {

std::array<PriorScores, 4> measured_prior();  // in the order of Label

}  // namespace forefeel
