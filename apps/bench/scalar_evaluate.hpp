#pragma once
// The baseline of an evaluation: the sum of paper Eq. 1 (r^3, linear p; or r^5 with stiffness), centre by centre at
// -O2, without vectors. Compiled once per instruction set and chosen like the loops of the models.

#include <cstddef>

namespace forefeel {

// positions: x y z of each centre, coefficients: 3 per centre then 3 x 4 of p.
void scalar_evaluate(std::size_t n, const double* positions, const double* coefficients, const double x[3],
                     double f[3]);
// r^5 on force and stiffness, quadratic p. centres: n x 15, position, coefficients of the force, of the
// stiffness (3 x 3); polynomial: 3 x 10 over 1 x y z xx yy zz xy xz yz.
void scalar_evaluate_hermite(std::size_t n, const double* centres, const double* polynomial,
                             const double x[3], double f[3]);

}  // namespace forefeel
