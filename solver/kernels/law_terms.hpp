#pragma once
// The laws, each in one place: psi(I1, I2, J) with its first derivatives d1 = dpsi/dI1, d2, dj and the second
// derivatives d11, djj that are not zero (no law here has mixed ones). T is double, or Lanes: eight numbers that a
// vector instruction treats at once. From these few numbers
//   P     = 2 d1 F + 2 d2 (I1 F - F C) + dj cof F
//   dP    = 2 d1 dF + 4 d11 (F:dF) F + 2 d2 (2 (F:dF) F + I1 dF - dF C - F dF^T F - F F^T dF)
//           + djj (cof F:dF) cof F + dj dcof
// follow for all laws alike. The linear law is no function of the invariants and is written out beside them.
//
// Everything is in an unnamed namespace on purpose: the kernels are compiled once per instruction set, and no
// function compiled for a newer one may be picked by the linker for general use. Include in those files only.

#include "solver/kernels/kernels.hpp"

namespace forefeel {
namespace {

using Lanes = double __attribute__((vector_size(64)));
using LaneBits = long long __attribute__((vector_size(64)));

#define FOREFEEL_INLINE __attribute__((always_inline)) inline

FOREFEEL_INLINE double least(double a, double b) {
  return b < a ? b : a;
}
FOREFEEL_INLINE Lanes least(Lanes a, Lanes b) {
  return b < a ? b : a;
}
template <class T>
FOREFEEL_INLINE T spread(double value) {
  return value - T{};
}

FOREFEEL_INLINE double logarithm(double x) {
  return __builtin_log(x);
}

// ln x for eight positive normal numbers, within 2 ulp: x = 2^k m, m in [sqrt(1/2), sqrt(2)),
// ln m = 2 artanh s = 2 s (1 + s^2/3 + s^4/5 + ...), s = (m - 1)/(m + 1), |s| < 0.1716: twelve terms suffice.
FOREFEEL_INLINE Lanes logarithm(Lanes x) {
  const long long one = 0x3ff0000000000000LL, root_half = 0x3fe6a09e667f3bcdLL;
  LaneBits bits;
  __builtin_memcpy(&bits, &x, sizeof bits);
  const LaneBits shifted = bits + (one - root_half);
  const LaneBits exponent = (shifted >> 52) - 1023;
  const LaneBits mantissa = (shifted & 0x000fffffffffffffLL) + root_half;
  Lanes m;
  __builtin_memcpy(&m, &mantissa, sizeof m);
  // exponent to floating point: added to the bits of 1.5 * 2^52
  const LaneBits biased = exponent + 0x4338000000000000LL;
  Lanes k;
  __builtin_memcpy(&k, &biased, sizeof k);
  k -= 6755399441055744.0;
  const Lanes f = m - 1.0;
  const Lanes s = f / (f + 2.0), z = s * s;
  Lanes p = z * (1.0 / 23) + 1.0 / 21;
  p = p * z + 1.0 / 19;
  p = p * z + 1.0 / 17;
  p = p * z + 1.0 / 15;
  p = p * z + 1.0 / 13;
  p = p * z + 1.0 / 11;
  p = p * z + 1.0 / 9;
  p = p * z + 1.0 / 7;
  p = p * z + 1.0 / 5;
  p = p * z + 1.0 / 3;
  const Lanes log_m = s * 2.0 + (s * 2.0) * z * p;
  return k * 0.69314718055994530942 + log_m;
}

template <class T>
struct Terms {
  T psi{}, d1{}, d2{}, dj{}, d11{}, djj{};
};

struct NeoHookean {
  static constexpr bool linear = false, uses_i2 = false, uses_j = true, uses_11 = false,
                        needs_positive_j = true;
  template <class T>
  static FOREFEEL_INLINE Terms<T> terms(const LawConstants& c, T i1, T, T j) {
    const T log_j = logarithm(j), inverse = 1.0 / j;
    Terms<T> t;
    t.psi = (0.5 * c.mu) * (i1 - 3.0) - c.mu * log_j + (0.5 * c.lambda) * log_j * log_j;
    t.d1 = spread<T>(0.5 * c.mu);
    t.dj = (c.lambda * log_j - c.mu) * inverse;
    t.djj = (c.lambda + c.mu - c.lambda * log_j) * inverse * inverse;
    return t;
  }
};

struct StableNeoHookean {
  static constexpr bool linear = false, uses_i2 = false, uses_j = true, uses_11 = true,
                        needs_positive_j = false;
  template <class T>
  static FOREFEEL_INLINE Terms<T> terms(const LawConstants& c, T i1, T, T j) {
    const T inverse = 1.0 / (i1 + 1.0);
    const double at_rest = 0.5 * c.l * (1 - c.a) * (1 - c.a);
    Terms<T> t;
    // ln(I1 + 1) is counted from ln 4
    t.psi = (0.5 * c.m) * (i1 - 3.0) + (0.5 * c.l) * (j - c.a) * (j - c.a) - at_rest -
            (0.5 * c.m) * logarithm((i1 + 1.0) * 0.25);
    t.d1 = (0.5 * c.m) * (1.0 - inverse);
    t.d11 = (0.5 * c.m) * inverse * inverse;
    t.dj = c.l * (j - c.a);
    t.djj = spread<T>(c.l);
    return t;
  }
};

struct MooneyRivlin {
  static constexpr bool linear = false, uses_i2 = true, uses_j = true, uses_11 = false,
                        needs_positive_j = true;
  template <class T>
  static FOREFEEL_INLINE Terms<T> terms(const LawConstants& c, T i1, T i2, T j) {
    const double pull = 2 * (c.c1 + 2 * c.c2);
    const T log_j = logarithm(j), inverse = 1.0 / j;
    Terms<T> t;
    t.psi = c.c1 * (i1 - 3.0) + c.c2 * (i2 - 3.0) - pull * log_j + (0.5 * c.lambda) * log_j * log_j;
    t.d1 = spread<T>(c.c1);
    t.d2 = spread<T>(c.c2);
    t.dj = (c.lambda * log_j - pull) * inverse;
    t.djj = (c.lambda + pull - c.lambda * log_j) * inverse * inverse;
    return t;
  }
};

// tr G = (I1 - 3)/2 and G:G = (I1^2 - 2 I2 - 2 I1 + 3)/4.
struct StVenantKirchhoff {
  static constexpr bool linear = false, uses_i2 = true, uses_j = false, uses_11 = true,
                        needs_positive_j = false;
  template <class T>
  static FOREFEEL_INLINE Terms<T> terms(const LawConstants& c, T i1, T i2, T) {
    const T g = i1 - 3.0;
    Terms<T> t;
    t.psi = (0.125 * c.lambda) * g * g + (0.25 * c.mu) * (i1 * i1 - 2.0 * i2 - 2.0 * i1 + 3.0);
    t.d1 = (0.25 * c.lambda) * g + (0.5 * c.mu) * (i1 - 1.0);
    t.d2 = spread<T>(-0.5 * c.mu);
    t.d11 = spread<T>(0.25 * c.lambda + 0.5 * c.mu);
    return t;
  }
};

struct Linear {
  static constexpr bool linear = true, uses_i2 = false, uses_j = false, uses_11 = false,
                        needs_positive_j = false;
};

// One point of the material: F and what the derivatives of the invariants need.
template <class T>
struct Point {
  T f[9];    // F row by row
  T cof[9];  // cofactor of F = dJ/dF
  T c[9];    // C = F^T F     (laws with I2)
  T b[9];    // B = F F^T     (laws with I2)
  T i1, i2, j;
  Terms<T> t;
};

template <class T>
FOREFEEL_INLINE void cofactor(const T* f, T* k) {
  k[0] = f[4] * f[8] - f[5] * f[7];
  k[1] = f[5] * f[6] - f[3] * f[8];
  k[2] = f[3] * f[7] - f[4] * f[6];
  k[3] = f[2] * f[7] - f[1] * f[8];
  k[4] = f[0] * f[8] - f[2] * f[6];
  k[5] = f[1] * f[6] - f[0] * f[7];
  k[6] = f[1] * f[5] - f[2] * f[4];
  k[7] = f[2] * f[3] - f[0] * f[5];
  k[8] = f[0] * f[4] - f[1] * f[3];
}

// point.f holds F; fills the rest.
template <class Law, class T>
FOREFEEL_INLINE void prepare(const LawConstants& c, Point<T>& p) {
  const T* f = p.f;
  cofactor(f, p.cof);
  p.j = f[0] * p.cof[0] + f[1] * p.cof[1] + f[2] * p.cof[2];
  if constexpr (!Law::linear) {
    p.i1 = f[0] * f[0] + f[1] * f[1] + f[2] * f[2] + f[3] * f[3] + f[4] * f[4] + f[5] * f[5] + f[6] * f[6] +
           f[7] * f[7] + f[8] * f[8];
    if constexpr (Law::uses_i2) {
      T square{};
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
          p.c[3 * i + k] = f[i] * f[k] + f[3 + i] * f[3 + k] + f[6 + i] * f[6 + k];
          p.b[3 * i + k] = f[3 * i] * f[3 * k] + f[3 * i + 1] * f[3 * k + 1] + f[3 * i + 2] * f[3 * k + 2];
          square += p.c[3 * i + k] * p.c[3 * i + k];
        }
      p.i2 = 0.5 * (p.i1 * p.i1 - square);
    } else {
      p.i2 = T{};
    }
    p.t = Law::template terms<T>(c, p.i1, p.i2, p.j);
  } else {
    const T e0 = f[0] - 1.0, e1 = f[4] - 1.0, e2 = f[8] - 1.0, trace = e0 + e1 + e2;
    const T s0 = f[1] + f[3], s1 = f[2] + f[6], s2 = f[5] + f[7];
    p.t.psi = (0.5 * c.lambda) * trace * trace + c.mu * (e0 * e0 + e1 * e1 + e2 * e2) +
              (0.5 * c.mu) * (s0 * s0 + s1 * s1 + s2 * s2);
  }
}

// P(F), row by row.
template <class Law, class T>
FOREFEEL_INLINE void stress(const LawConstants& c, const Point<T>& p, T* out) {
  const T* f = p.f;
  if constexpr (Law::linear) {
    const T pressure = c.lambda * ((f[0] - 1.0) + (f[4] - 1.0) + (f[8] - 1.0));
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        out[3 * i + k] =
            i == k ? (2 * c.mu) * (f[4 * i] - 1.0) + pressure : c.mu * (f[3 * i + k] + f[3 * k + i]);
      }
    return;
  } else {
    T along = 2.0 * p.t.d1;
    if constexpr (Law::uses_i2) along += 2.0 * p.t.d2 * p.i1;
    for (int i = 0; i < 9; ++i) out[i] = along * f[i];
    if constexpr (Law::uses_i2) {
      const T twice = 2.0 * p.t.d2;
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
          out[3 * i + k] -=
              twice * (f[3 * i] * p.c[k] + f[3 * i + 1] * p.c[3 + k] + f[3 * i + 2] * p.c[6 + k]);
    }
    if constexpr (Law::uses_j)
      for (int i = 0; i < 9; ++i) out[i] += p.t.dj * p.cof[i];
  }
}

// dP for a change dF of F.
template <class Law, class T>
FOREFEEL_INLINE void stress_change(const LawConstants& c, const Point<T>& p, const T* d, T* out) {
  const T* f = p.f;
  if constexpr (Law::linear) {
    const T pressure = c.lambda * (d[0] + d[4] + d[8]);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        out[3 * i + k] = c.mu * (d[3 * i + k] + d[3 * k + i]);
        if (i == k) out[3 * i + k] += pressure;
      }
    return;
  } else {
    T same = 2.0 * p.t.d1;
    if constexpr (Law::uses_i2) same += 2.0 * p.t.d2 * p.i1;
    for (int i = 0; i < 9; ++i) out[i] = same * d[i];
    if constexpr (Law::uses_i2 || Law::uses_11) {
      T along{};
      for (int i = 0; i < 9; ++i) along += f[i] * d[i];
      T factor{};
      if constexpr (Law::uses_11) factor += 4.0 * p.t.d11;
      if constexpr (Law::uses_i2) factor += 4.0 * p.t.d2;
      along *= factor;
      for (int i = 0; i < 9; ++i) out[i] += along * f[i];
    }
    if constexpr (Law::uses_i2) {
      const T twice = 2.0 * p.t.d2;
      T mixed[9];  // dF^T F
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
          mixed[3 * i + k] = d[i] * f[k] + d[3 + i] * f[3 + k] + d[6 + i] * f[6 + k];
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
          T sum = d[3 * i] * p.c[k] + d[3 * i + 1] * p.c[3 + k] + d[3 * i + 2] * p.c[6 + k];
          sum += f[3 * i] * mixed[k] + f[3 * i + 1] * mixed[3 + k] + f[3 * i + 2] * mixed[6 + k];
          sum += p.b[3 * i] * d[k] + p.b[3 * i + 1] * d[3 + k] + p.b[3 * i + 2] * d[6 + k];
          out[3 * i + k] -= twice * sum;
        }
    }
    if constexpr (Law::uses_j) {
      T along{};
      for (int i = 0; i < 9; ++i) along += p.cof[i] * d[i];
      along *= p.t.djj;
      for (int i = 0; i < 9; ++i) out[i] += along * p.cof[i];
      // dcof: each entry of the cofactor is bilinear in F
      const T g = p.t.dj;
      out[0] += g * (d[4] * f[8] + f[4] * d[8] - d[5] * f[7] - f[5] * d[7]);
      out[1] += g * (d[5] * f[6] + f[5] * d[6] - d[3] * f[8] - f[3] * d[8]);
      out[2] += g * (d[3] * f[7] + f[3] * d[7] - d[4] * f[6] - f[4] * d[6]);
      out[3] += g * (d[2] * f[7] + f[2] * d[7] - d[1] * f[8] - f[1] * d[8]);
      out[4] += g * (d[0] * f[8] + f[0] * d[8] - d[2] * f[6] - f[2] * d[6]);
      out[5] += g * (d[1] * f[6] + f[1] * d[6] - d[0] * f[7] - f[0] * d[7]);
      out[6] += g * (d[1] * f[5] + f[1] * d[5] - d[2] * f[4] - f[2] * d[4]);
      out[7] += g * (d[2] * f[3] + f[2] * d[3] - d[0] * f[5] - f[0] * d[5]);
      out[8] += g * (d[0] * f[4] + f[0] * d[4] - d[1] * f[3] - f[1] * d[3]);
    }
  }
}

}  // namespace
}  // namespace forefeel
