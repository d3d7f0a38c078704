#pragma once
// Checks whether a state, from a worker or known at a given time (--arrivals), is plausible for the body that its
// neighbours belong to.
//
// From a neighbour j with stiffness K_j [N/m], at a distance d_j of at most two spacings [m], forces of the size
// s_j = |f_j| + |K_j| d_j [N] are expected (Frobenius norm). A state is far too strong if |f| > 100 max s_j or
// |K| > 100 max |K_j|. No body with a valid mesh stiffens by that much within two spacings. A solver that returns
// another unit, or a faulty link that returns a state of another body, exceeds the limit.
//
// Without such a neighbour, as for the first state, the state is compared with the body itself. At rest no body is
// stiffer than K_b [N/m], the stiffness with all nodes held but those of the contact
// (solver/body/contact_stiffness.hpp). A state is far too strong if |K| > c |K_b| or |f| > c |K_b| max(|x|, h), with
// the spacing h [m], c = 3 at rest, and c = 100 elsewhere, as a body may stiffen. K_b is 2 to 20 times the stiffness of
// usual meshes, so a first state that is 1000 times too strong is detected. If K_b is unknown, the state is accepted.

#include "geometry/coverage/state_space.hpp"

namespace forefeel {

constexpr double implausible_factor = 100;
constexpr double implausible_at_rest = 3;

// True also for a position or force that is not finite. Allocates; planner's thread.
// stiffest: K_b [N/m]; zero: unknown.
bool is_far_too_strong(const State& state, const StateSpace& space, const Mat3& stiffest = Mat3::Zero());

}  // namespace forefeel
