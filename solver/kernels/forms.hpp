#pragma once
// Homogeneous polynomials (forms) in three variables d, coefficients in the order of EnergyJet: x^n, x^(n-1) y,
// x^(n-1) z, x^(n-2) y^2, ... Where a series in t has a form of degree k at t^k, the whole is a polynomial in t d.
// Include in kernel files only (see element_lanes.hpp).

#include "solver/kernels/law_terms.hpp"

namespace forefeel {
namespace {

constexpr int form_size(int degree) {
  return (degree + 1) * (degree + 2) / 2;
}

// Powers of y and z in a coefficient; they tell its place, whatever the degree.
constexpr int power_of_y[21] = {0, 1, 0, 2, 1, 0, 3, 2, 1, 0, 4, 3, 2, 1, 0, 5, 4, 3, 2, 1, 0};
constexpr int power_of_z[21] = {0, 0, 1, 0, 1, 2, 0, 1, 2, 3, 0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 5};
constexpr int product_at(int i, int k) {
  const int z = power_of_z[i] + power_of_z[k], beside = power_of_y[i] + power_of_y[k] + z;
  return beside * (beside + 1) / 2 + z;
}

// The numbers 0 .. n - 1, so that the loops below are written out whatever the compiler's limits.
template <int... k>
struct Numbers {};
template <int n, int... k>
struct NumbersTo : NumbersTo<n - 1, n - 1, k...> {};
template <int... k>
struct NumbersTo<0, k...> {
  using Type = Numbers<k...>;
};

// out += a b, or -= a b, of forms of degree m and n.
template <int n, int sign, int... k>
FOREFEEL_INLINE void add_products(const Lanes* a, const Lanes* b, Lanes* out, Numbers<k...>) {
  constexpr int size = form_size(n);
  if constexpr (sign > 0)
    ((out[product_at(k / size, k % size)] += a[k / size] * b[k % size]), ...);
  else
    ((out[product_at(k / size, k % size)] -= a[k / size] * b[k % size]), ...);
}
template <int m, int n, int sign = 1>
FOREFEEL_INLINE void add_product(const Lanes* a, const Lanes* b, Lanes* out) {
  add_products<n, sign>(a, b, out, typename NumbersTo<form_size(m) * form_size(n)>::Type{});
}

// out += factor a.
template <int n>
FOREFEEL_INLINE void add_scaled(Lanes factor, const Lanes* a, Lanes* out) {
  add_product<0, n>(&factor, a, out);
}

// 3 x 3 matrices of forms, entry by entry; a matrix of numbers is one of degree 0.
template <int n>
using MatrixForm = const Lanes (*)[form_size(n)];

FOREFEEL_INLINE MatrixForm<0> constant(const Lanes* f) {
  return reinterpret_cast<MatrixForm<0>>(f);
}

// out += a : b.
template <int m, int n>
FOREFEEL_INLINE void add_contraction(MatrixForm<m> a, MatrixForm<n> b, Lanes* out) {
  constexpr int size = form_size(m + n);
  Lanes sum[size];
  for (int i = 0; i < size; ++i) sum[i] = out[i];
  for (int e = 0; e < 9; ++e) add_product<m, n>(a[e], b[e], sum);
  for (int i = 0; i < size; ++i) out[i] = sum[i];
}

// Entry e of the cofactor is f[plus[e][0]] f[plus[e][1]] - f[minus[e][0]] f[minus[e][1]].
constexpr int minor_plus[9][2] = {{4, 8}, {5, 6}, {3, 7}, {2, 7}, {0, 8}, {1, 6}, {1, 5}, {2, 3}, {0, 4}};
constexpr int minor_minus[9][2] = {{5, 7}, {3, 8}, {4, 6}, {1, 8}, {2, 6}, {0, 7}, {2, 4}, {0, 5}, {1, 3}};

// Cofactor of a, and its polar form: cof(a + b) = cof a + X(a, b) + cof b.
template <int n>
FOREFEEL_INLINE void form_cofactor(MatrixForm<n> a, Lanes (*out)[form_size(2 * n)]) {
  for (int e = 0; e < 9; ++e) {
    Lanes sum[form_size(2 * n)]{};
    add_product<n, n>(a[minor_plus[e][0]], a[minor_plus[e][1]], sum);
    add_product<n, n, -1>(a[minor_minus[e][0]], a[minor_minus[e][1]], sum);
    for (int i = 0; i < form_size(2 * n); ++i) out[e][i] = sum[i];
  }
}
template <int m, int n>
FOREFEEL_INLINE void polar_cofactor(MatrixForm<m> a, MatrixForm<n> b, Lanes (*out)[form_size(m + n)]) {
  for (int e = 0; e < 9; ++e) {
    Lanes sum[form_size(m + n)]{};
    for (int side = 0; side < 2; ++side) {
      add_product<m, n>(a[minor_plus[e][side]], b[minor_plus[e][1 - side]], sum);
      add_product<m, n, -1>(a[minor_minus[e][side]], b[minor_minus[e][1 - side]], sum);
    }
    for (int i = 0; i < form_size(m + n); ++i) out[e][i] = sum[i];
  }
}

// Symmetric matrices: entries 00, 01, 02, 11, 12, 22.
constexpr int upper_row[6] = {0, 0, 0, 1, 1, 2}, upper_column[6] = {0, 1, 2, 1, 2, 2};
constexpr int upper_entry[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

// out = a^T b, if that is symmetric, or its sum with its transpose; or added to out.
template <int m, int n, bool with_transpose, bool added = false>
FOREFEEL_INLINE void set_square(MatrixForm<m> a, MatrixForm<n> b, Lanes (*out)[form_size(m + n)]) {
  constexpr int size = form_size(m + n);
  for (int e = 0; e < 6; ++e) {
    Lanes sum[size];
    for (int i = 0; i < size; ++i) sum[i] = added ? out[e][i] : Lanes{};
    for (int k = 0; k < 9; k += 3) {
      add_product<m, n>(a[k + upper_row[e]], b[k + upper_column[e]], sum);
      if (with_transpose) add_product<m, n>(a[k + upper_column[e]], b[k + upper_row[e]], sum);
    }
    for (int i = 0; i < size; ++i) out[e][i] = sum[i];
  }
}
// out += factor a : b.
template <int m, int n>
FOREFEEL_INLINE void add_symmetric_contraction(Lanes factor, MatrixForm<m> a, MatrixForm<n> b, Lanes* out) {
  Lanes sum[form_size(m + n)]{};
  for (int e = 0; e < 6; ++e) {
    Lanes scaled[form_size(m)];
    const Lanes by = upper_row[e] == upper_column[e] ? factor : 2.0 * factor;
    for (int i = 0; i < form_size(m); ++i) scaled[i] = by * a[e][i];
    add_product<m, n>(scaled, b[e], sum);
  }
  for (int i = 0; i < form_size(m + n); ++i) out[i] += sum[i];
}
template <int n>
FOREFEEL_INLINE void add_trace(MatrixForm<n> c, Lanes* out) {
  for (int i = 0; i < form_size(n); ++i) out[i] += c[0][i] + c[3][i] + c[5][i];
}

}  // namespace
}  // namespace forefeel
