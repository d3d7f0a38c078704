#pragma once
// Checks whether a solved state is plausible for the body that its neighbours belong to.
//
// From a neighbour j with stiffness K_j [N/m], at a distance d_j of at most two spacings [m], forces of the size
// s_j = |f_j| + |K_j| d_j [N] are expected (Frobenius norm). A state is far too strong if |f| > 100 max s_j or
// |K| > 100 max |K_j|. No body with a valid mesh stiffens by that much within two spacings. A solver that returns
// another unit, or a faulty link that returns a state of another body, exceeds the limit. Without such a neighbour
// the state is accepted.

#include "geometry/coverage/state_space.hpp"

namespace forefeel {

constexpr double implausible_factor = 100;

// True also for a position or force that is not finite. Allocates; planner's thread.
bool is_far_too_strong(const State& state, const StateSpace& space);

}  // namespace forefeel
