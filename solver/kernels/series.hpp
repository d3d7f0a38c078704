#pragma once
// Truncated power series a(t) = sum_{k < n} a_k t^k and their arithmetic, so that a law's own terms (law_terms.hpp),
// called with series, give the Taylor coefficients of psi and its derivatives along a path (A. Griewank, A. Walther,
// Evaluating Derivatives, 2008, ch. 13). T is double or Lanes. Include in kernel files only (see element_lanes.hpp).

#include "solver/kernels/element_lanes.hpp"

namespace forefeel {
namespace {

template <class T, int n>
struct Series {
  T at[n]{};

  Series& operator+=(const Series& b) { return *this = *this + b; }
  Series& operator*=(const Series& b) { return *this = *this * b; }

  friend FOREFEEL_INLINE Series operator+(const Series& a, const Series& b) {
    Series c;
    for (int k = 0; k < n; ++k) c.at[k] = a.at[k] + b.at[k];
    return c;
  }
  friend FOREFEEL_INLINE Series operator-(const Series& a, const Series& b) {
    Series c;
    for (int k = 0; k < n; ++k) c.at[k] = a.at[k] - b.at[k];
    return c;
  }
  friend FOREFEEL_INLINE Series operator*(const Series& a, const Series& b) {
    Series c;
    for (int k = 0; k < n; ++k) {
      c.at[k] = a.at[0] * b.at[k];
      for (int i = 1; i <= k; ++i) c.at[k] += a.at[i] * b.at[k - i];
    }
    return c;
  }
  friend FOREFEEL_INLINE Series operator*(double a, const Series& b) {
    Series c;
    for (int k = 0; k < n; ++k) c.at[k] = a * b.at[k];
    return c;
  }
  friend FOREFEEL_INLINE Series operator*(const Series& a, double b) { return b * a; }
  friend FOREFEEL_INLINE Series operator+(const Series& a, double b) {
    Series c = a;
    c.at[0] += b;
    return c;
  }
  friend FOREFEEL_INLINE Series operator-(const Series& a, double b) { return a + -b; }
  friend FOREFEEL_INLINE Series operator-(double a, const Series& b) { return -1.0 * b + a; }
  friend FOREFEEL_INLINE Series operator/(double a, const Series& b) {
    Series c;
    const T inverse = 1.0 / b.at[0];
    c.at[0] = a * inverse;
    for (int k = 1; k < n; ++k) {
      T sum{};
      for (int i = 1; i <= k; ++i) sum += b.at[i] * c.at[k - i];
      c.at[k] = -sum * inverse;
    }
    return c;
  }
};

// k l_k a_0 = k a_k - sum_{0 < i < k} i l_i a_{k - i}, from a l' = a'.
template <class T, int n>
FOREFEEL_INLINE Series<T, n> logarithm(const Series<T, n>& a) {
  Series<T, n> l;
  const T inverse = 1.0 / a.at[0];
  l.at[0] = logarithm(a.at[0]);
  for (int k = 1; k < n; ++k) {
    T sum = double(k) * a.at[k];
    for (int i = 1; i < k; ++i) sum -= double(i) * l.at[i] * a.at[k - i];
    l.at[k] = sum * inverse * (1.0 / k);
  }
  return l;
}

}  // namespace
}  // namespace forefeel
