#pragma once
// Leave-one-out errors: how well the other states predict each state, and the ridge that predicts noisy
// states best.
//   e_b = f_b - f~_(-b) = G_bb^-1 lambda_b,     lambda = G f
// b: the rows of one state (one, or four if the stiffness is used); f~_(-b): the model without them; G: the
// upper left block of the inverse of [K + rho I, P; P^T, 0]; K = s A the kernel (s = -1 for r and r^5, else
// 1); rho the ridge (nugget). The formula is exact for every rho (Allen's PRESS; Wahba, Spline Models for
// Observational Data, 1990, ch. 4). One eigendecomposition of K on the null space of P^T takes O(n^3); each rho then
// takes O(n^2).

#include <span>
#include <vector>

#include "approx/model/model.hpp"

namespace forefeel {

// Returns f - f~ [N] at each usable state, f~ the model of the others; NaN if they do not determine a model. Scale and
// centre are those of the whole set. Uses kernel, data and ridge of the options.
std::vector<Vec3> leave_one_out(std::span<const State> states, const ModelOptions& options);

struct RidgeChoice {
  double ridge = 0;       // in the units of ModelOptions::ridge
  double missed = 0;      // root mean square of the errors with this ridge [N]
  double unsmoothed = 0;  // the same without a ridge [N]
};

// The ridge with the least error over sets of options.neighbours states from the whole space. Tries 0 and half powers
// of ten from 1e-12 to 10.
RidgeChoice choose_ridge(const StateSpace& space, const ModelOptions& options);

// The power function of an RBF interpolant (Wendland, Scattered Data Approximation, 2005, ch. 11),
//   P(x)^2 = s [ phi(0) - 2 u . k(x) + u^T A u ]   [m^k for phi = r^k],   [A Q; Q^T 0][u; v] = [k(x); q(x)]
// u: weights of the data in f~(x); k_i(x): kernel between the value at x and functional i; q: polynomials; s
// = +1 for r^3, -1 for r and r^5. With stiffness data each state has three derivative functionals besides its
// value. P(x) does not depend on the values of the field. The error at x is at most P(x) times a norm of the
// field that is the same everywhere, so P ranks places by their possible error.
// P(x) [m^(k/2)] from the given states; infinite if they do not determine the polynomial. O(n^3) and allocates, so not
// for a real-time loop. Uses kernel and data as given, without step-down to a simpler model.
double power_function(std::span<const State> states, const ModelOptions& options, const Vec3& x);

}  // namespace forefeel
