#pragma once
// The loops of dense_kernels.hpp that have files of their own, and what these files share. Compiled once per
// instruction set.

#include <type_traits>

#include "approx/loops/dense_kernels.hpp"
#include "approx/loops/lanes.hpp"

namespace forefeel::FOREFEEL_ISA {

void update_columns(double* l, std::size_t stride, double* inverse, double* y, std::size_t first,
                    std::size_t last, std::size_t m, double* v, std::size_t vs, double* side,
                    std::size_t count);
void solve_transposed3(const double* l, std::size_t stride, const double* inverse, std::size_t m, double* y0,
                       double* y1, double* y2);
void orthogonalise(std::size_t q, std::size_t m, double* columns, std::size_t stride, double* upper,
                   double* right);
void gram(std::size_t q, std::size_t m, const double* l, std::size_t stride, const double* weight,
          double* gram);
void dots3(std::size_t q, std::size_t m, const double* a, const double* v, std::size_t stride, double* out);

namespace {

using dense::border;
constexpr std::size_t most_together = width == 8 ? 20 : 8;  // vectors of an update that fit into registers

// action(n) with n, Least <= n <= Most, known when this is compiled.
template <std::size_t Least, std::size_t Most, class Action>
FOREFEEL_INLINE void with_count(std::size_t n, const Action& action) {
  if constexpr (Least < Most)
    if (n != Least) return with_count<Least + 1, Most>(n, action);
  action(std::integral_constant<std::size_t, Least>{});
}

}  // namespace
}  // namespace forefeel::FOREFEEL_ISA
