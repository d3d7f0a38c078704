#pragma once
// Whether a solved state can be one of the body that its neighbours belong to.
//
// A neighbour j with stiffness, at a distance d_j of at most two spacings, expects forces of the size
// s_j = |f_j| + |K_j| d_j (Frobenius norm). A state is far too strong where |f| > 100 max s_j or
// |K| > 100 max |K_j|. No body stiffens by that within two spacings unless its mesh is wrong; a solver that
// returns another unit, or a broken link that returns another body's state, does more. Without such a
// neighbour nothing can be said, and nothing is.

#include "geometry/coverage/state_space.hpp"

namespace forefeel {

constexpr double implausible_factor = 100;

// Not finite counts as far too strong. Allocates; planner's thread.
bool is_far_too_strong(const State& state, const StateSpace& space);

}  // namespace forefeel
