#pragma once
// Polynomials of degree 0, 1 or 2 in scaled coordinates y, given by their values at q = 1, 4 or 10 fixed
// anchor points a_j (corners of a tetrahedron about the unit ball, and its edge midpoints for degree 2):
//   p(y) = sum_j l_j(y) p(a_j)     l_j: Lagrange polynomials
// and the projected kernel, which is zero on polynomials:
//   K(x, y) = s [phi(x - y) - l(x) . v(y) - v(x) . l(y)]
//   v(y)    = phi(y - a) - 1/2 G l(y)
//   G_jk    = phi(a_j - a_k)
// K is positive definite on any set of points without the anchors; s = +1 for r^3, -1 for r and r^5.

#include <array>
#include <cstddef>

#include "approx/model/model_options.hpp"

namespace forefeel::detail {

constexpr int power_of(Kernel kernel) {  // k of phi(r) = r^k
  return kernel == Kernel::linear ? 1 : kernel == Kernel::cubic ? 3 : 5;
}

inline constexpr std::size_t max_terms = 10;

constexpr std::size_t polynomial_terms(int degree) {
  return degree == 0 ? 1 : degree == 1 ? 4 : 10;
}

// l(y) and its gradient: l[j], gradient[3 * j + d] = dl_j/dy_d.
void lagrange(int degree, const double y[3], double* l, double* gradient);
// Anchor j.
std::array<double, 3> anchor(std::size_t j);
// Coefficients of sum_j values[j] l_j over the monomials 1, x, y, z, xx, yy, zz, xy, xz, yz.
void to_monomials(int degree, const double* values, double* monomials);

}  // namespace forefeel::detail
