#pragma once
// Stress and tangent of a hyperelastic law psi(I1, I2, J) [J/m^3] at one point, from its first derivatives
// d1 = dpsi/dI1, d2, dj and those second derivatives that are not zero, d11 and djj:
//   P  = 2 d1 F + 2 d2 (I1 F - F C) + dj cof F
//   dP = 2 d1 dF + 4 d11 (F:dF) F + 2 d2 (2 (F:dF) F + I1 dF - dF C - F dF^T F - F F^T dF)
//        + djj (cof F:dF) cof F + dj dcof
// F deformation gradient, J = det F, C = F^T F, I1 = tr C, I2 = (I1^2 - tr C^2)/2. T is double or Lanes
// (element_lanes.hpp). A law that is not a function of the invariants defines energy, stress and stress_change itself
// (law_linear.cpp). Include in kernel files only (see element_lanes.hpp).

#include "solver/kernels/element_lanes.hpp"

namespace forefeel {
namespace {

// psi and its derivatives, as a law returns them.
template <class T>
struct Terms {
  T psi{}, d1{}, d2{}, dj{}, d11{}, djj{};
};

// Properties of a law. A law derives from this struct and redefines those that differ.
struct LawDefaults {
  static constexpr const char* form = "";      // which of several forms of the law; part of a body's identity
  static constexpr bool linear = false;        // f = -K x exactly
  static constexpr bool of_invariants = true;  // gives terms(); false: energy(), stress(), stress_change()
  static constexpr bool uses_i2 = false;       // d2 is not zero everywhere
  static constexpr bool uses_j = false;        // dj is not zero everywhere
  static constexpr bool uses_11 = false;       // d11 is not zero everywhere
  static constexpr bool needs_positive_j = false;  // psi grows without bound as J -> 0
  static constexpr bool softens =
      false;  // loses stiffness in compression: a neighbour's factor is less accurate
  // Jets are not trusted where they take a principal stretch below this; measured on one node of a neo-Hookean body:
  // every error of more than 3 % lay beyond it.
  static constexpr double least_stretch = 0.5;
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
  if constexpr (Law::of_invariants) {
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
    p.t.psi = Law::template energy<T>(c, f);
  }
}

// P(F), row by row.
template <class Law, class T>
FOREFEEL_INLINE void stress(const LawConstants& c, const Point<T>& p, T* out) {
  const T* f = p.f;
  if constexpr (!Law::of_invariants) {
    Law::template stress<T>(c, f, out);
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
  if constexpr (!Law::of_invariants) {
    Law::template stress_change<T>(c, d, out);
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
