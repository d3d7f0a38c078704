#pragma once
// The power function of an RBF interpolant (Wendland, Scattered Data Approximation, 2005, ch. 11): how far
// the value at x is from being determined by the data at the states, whatever the field,
//   P(x)^2 = s [ phi(0) - 2 u . k(x) + u^T A u ],   [A Q; Q^T 0][u; v] = [k(x); q(x)]
// u the weights that the data get in f~(x), k_i(x) the kernel between the value at x and functional i, q the
// polynomials; s = +1 for r^3, -1 for r and r^5. With stiffness data every state has three derivative
// functionals besides its value. An error bound is P(x) times a norm of the field that is the same
// everywhere, so that P ranks places. Unit m^(k/2) for phi = r^k.

#include <span>

#include "approx/model/model.hpp"

namespace forefeel {

// P(x) from the given states [m^(k/2)]; infinite where they do not determine the polynomial. O(n^3),
// allocates: not for a render loop. Kernel and data are taken as they are, without step-down.
double power_function(std::span<const State> states, const ModelOptions& options, const Vec3& x);

}  // namespace forefeel
