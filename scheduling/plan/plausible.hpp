#pragma once
// Whether a solved state can be one of the body that its neighbours belong to.
//
// A neighbour j with stiffness, at a distance d_j of at most two spacings, expects forces of the size
// s_j = |f_j| + |K_j| d_j (Frobenius norm). A state is far too strong where |f| > 100 max s_j or
// |K| > 100 max |K_j|. No body stiffens by that within two spacings unless its mesh is wrong; a solver that
// returns another unit, or a broken link that returns another body's state, does more.
//
// Without such a neighbour, as the first state is, it is compared with the body itself: no body is stiffer at rest
// than K_b, the one whose nodes beside the contact are all held (solver/body/contact_bound.hpp). A state is far too
// strong where |K| > c |K_b| or |f| > c |K_b| max(|x|, h), h the spacing, c = 3 at rest and 100 elsewhere, where a
// body may have stiffened. K_b is 2 to 20 times the stiffness of usual meshes, so a first state 1000 times too strong
// is found. Where K_b is not known, nothing can be said of it, and nothing is.

#include "geometry/coverage/state_space.hpp"

namespace forefeel {

constexpr double implausible_factor = 100;
constexpr double implausible_at_rest = 3;

// Not finite counts as far too strong. Allocates; planner's thread.
// stiffest: K_b [N/m]; zero: unknown.
bool is_far_too_strong(const State& state, const StateSpace& space, const Mat3& stiffest = Mat3::Zero());

}  // namespace forefeel
