#pragma once
// Does the stiffness of measured states fit their forces? From a state a to a neighbour b at the distance d the force
// changes by about
//   f_b - f_a = -s K_a d,   s = 1.
// For each state s and the correlation of both sides come from its eight nearest states. Columns of the other sign
// (df/dx in place of -df/dx) have s < 0, another unit such as N/mm has s far from 1. Where noise in the force hides the
// change between neighbours, the correlation is small and nothing is said. A matrix fitted to the neighbours tells the
// two apart: if that one correlates (> 0.95) and K_a does not, K_a is of something else, as columns in another order.

#include <cstddef>
#include <span>
#include <string>

#include "geometry/states/state.hpp"

namespace forefeel {

struct StiffnessAgreement {
  std::size_t tried = 0;            // states with stiffness and neighbours
  std::size_t compared = 0;         // of them: those whose neighbours decide, |correlation| > 0.7
  std::size_t opposite = 0;         // of them: s < 0
  std::size_t surely_opposite = 0;  // of them: correlation < -0.9
  std::size_t unlike = 0;           // of those tried: forces change linearly, but not as K says
  std::size_t zero = 0;  // of those tried: K = 0 where forces change linearly; free places have no force
  double scale = 1;      // median |s| of them
};
// Of at most 500 states with stiffness, spread over the set. O(500 n).
StiffnessAgreement stiffness_agreement(std::span<const State> states);

// "the stiffness (k11 to k33) of all 80 states that could be compared has the other sign …"; empty where it fits.
std::string disagreement_in_words(const StiffnessAgreement& found);

}  // namespace forefeel
