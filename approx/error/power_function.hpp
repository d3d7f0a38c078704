#pragma once
// The power function of an RBF interpolant (Wendland, Scattered Data Approximation, 2005, ch. 11),
//   P(x)^2 = s [ phi(0) - 2 u . k(x) + u^T A u ]   [m^k for phi = r^k],   [A Q; Q^T 0][u; v] = [k(x); q(x)]
// u: weights of the data in f~(x); k_i(x): kernel between the value at x and functional i; q: polynomials; s
// = +1 for r^3, -1 for r and r^5. With stiffness data each state has three derivative functionals besides its
// value. P(x) does not depend on the values of the field. The error at x is at most P(x) times a norm of the
// field that is the same everywhere, so P ranks places by their possible error.

#include <span>

#include "approx/model/model.hpp"

namespace forefeel {

// P(x) [m^(k/2)] from the given states; infinite if they do not determine the polynomial. O(n^3) and allocates, so not
// for a real-time loop. Uses kernel and data as given, without step-down to a simpler model.
double power_function(std::span<const State> states, const ModelOptions& options, const Vec3& x);

}  // namespace forefeel
