#pragma once
// Polynomials of degree 0, 1 or 2 in scaled coordinates y, by their values at q = 1, 4 or 10 fixed anchor
// points a_j:
//   p(y) = sum_j l_j(y) p(a_j),   l_j the Lagrange polynomials (of a tetrahedron about the unit ball, with
//   its edge midpoints for degree 2)
// and the kernel that does not see them,
//   K(x, y) = s [phi(x - y) - l(x) . v(y) - v(x) . l(y)],   v(y) = phi(y - a) - 1/2 G l(y),  G_jk = phi(a_j -
//   a_k),
// which is positive definite on any points but the anchors (s = +1 for r^3, -1 for r and r^5).

#include <array>
#include <cstddef>

namespace forefeel::detail {

inline constexpr std::size_t max_terms = 10;

constexpr std::size_t polynomial_terms(int degree) {
  return degree == 0 ? 1 : degree == 1 ? 4 : 10;
}

// l and its gradient at y; l[j], gradient[3 * j + d].
void lagrange(int degree, const double y[3], double* l, double* gradient);
// Anchor j.
std::array<double, 3> anchor(std::size_t j);
// Coefficients over the monomials 1, x, y, z, xx, yy, zz, xy, xz, yz of sum_j values[j] l_j.
void to_monomials(int degree, const double* values, double* monomials);

}  // namespace forefeel::detail
