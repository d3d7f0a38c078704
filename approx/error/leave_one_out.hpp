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

}  // namespace forefeel
