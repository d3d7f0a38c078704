#pragma once
// The misfit of a model at its own states, in twice the working precision. It is used to refine a model whose factor
// has lost digits. Compiled for several instruction sets (instruction_set.hpp), without contraction and without
// -ffast-math.
//   m_c(i) = g_c(i) - [p_c(y_i) + sum_j a_jc phi(d) - phi'(d)/d (b_jc . d)],   d = y_i - y_j
// and, with stiffness data, the same for the three derivatives over y.

#include <cstddef>

namespace forefeel::exact {

struct Loops {
  // data: n centres (a multiple of 8) as in kernel_sums.hpp; polynomial[4 * t + c] over the monomials of
  // polynomial.hpp; given and misfit: 3 arrays, given_stride apart, for the values of the components and,
  // with stiffness data, 9 more for d g_c / dy_d at 3 + 3 c + d.
  void (*misfit)(int power, bool hermite, std::size_t n, const double* data, std::size_t stride,
                 const double* polynomial, const double* given, std::size_t given_stride, double* misfit);
};

const Loops& loops();  // those of instruction_set_in_use()

}  // namespace forefeel::exact
