#pragma once
// How well each state is foretold by the others, and the ridge that foretells best, for noisy states.
// With the kernel K = s A (s = -1 for r and r^5), the ridge rho on its diagonal and G the upper left block of
// the inverse of [K + rho I, P; P^T, 0], the coefficients are lambda = G f, and without the rows b of one state
// its own data are missed by
//   e_b = f_b - f~_(-b) = G_bb^-1 lambda_b
// exactly, for every rho (the formula of Allen's PRESS and of Wahba, Spline Models for Observational Data,
// 1990, ch. 4, with a block of four rows where the stiffness is used too). One eigendecomposition of K on the
// null space of P^T serves every rho: O(n^3), then O(n^2) each.

#include <span>
#include <vector>

#include "approx/model/model.hpp"

namespace forefeel {

// Force missed at each usable state by the model of the others [N]; NaN where they do not determine one.
// options: kernel, data, ridge (of all states: scale and centre stay those of the whole set).
std::vector<Vec3> leave_one_out(std::span<const State> states, const ModelOptions& options);

struct RidgeChoice {
  double ridge = 0;       // in the units of ModelOptions::ridge
  double missed = 0;      // root mean square of the forces missed with it [N]
  double unsmoothed = 0;  // the same with none [N]
};

// The ridge, 0 or a half power of ten from 1e-12 to 10, that misses least over sets of options.neighbours
// states from all over the space.
RidgeChoice choose_ridge(const StateSpace& space, const ModelOptions& options);

}  // namespace forefeel
