#pragma once
// Loops that fill rows of the kernel matrix, compiled for several instruction sets (instruction_set.hpp).
// Power k = 1, 3, 5 of phi(r) = r^k. Functionals: 0 value, 1..3 derivative along an axis.

#include <cstddef>

namespace forefeel::rows {

struct Loops {
  // out[i] = |a - p_i|^k
  void (*values)(int power, std::size_t n, const double* px, const double* py, const double* pz,
                 const double a[3], double* out);
  // out[t * stride + 4 * i + u]: functional t at a against functional u at p_i (k = 3 or 5).
  void (*hermite)(int power, std::size_t n, const double* px, const double* py, const double* pz,
                  const double a[3], double* out, std::size_t stride);
  // out[i] = weight[i] (out[i] - sum_j (la[j] v_j[i] + va[j] l_j[i])),  l_j at l[j * stride], q = 1, 4 or 10
  void (*project)(std::size_t q, std::size_t m, const double* l, const double* v, std::size_t stride,
                  const double* la, const double* va, const double* weight, double* out);
};

const Loops& loops();  // those of instruction_set_in_use()

}  // namespace forefeel::rows
