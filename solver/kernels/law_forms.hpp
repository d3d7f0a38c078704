#pragma once
// Taylor terms of a law at one point, as forms in d (forms.hpp), along F(t) = F + t G_1 + t^2 G_2 with G_k a matrix of
// forms of degree k. With X the polar form of the cofactor:
//   J_1 = cof F : G_1   J_2 = cof F : G_2 + F : cof G_1   J_3 = X(F, G_1) : G_2 + det G_1
//   J_4 = F : cof G_2 + cof G_1 : G_2                     J_5 = cof G_2 : G_1
//   C_1 = 2 sym F^T G_1   C_2 = 2 sym F^T G_2 + G_1^T G_1   C_3 = 2 sym G_1^T G_2   C_4 = G_2^T G_2
//   I1_k = tr C_k         I2_k = 1/2 sum_{i + j = k} (I1_i I1_j - C_i : C_j)
// psi is a function of I1 plus one of J plus d2 I2 (law_terms.hpp).
// Include in kernel files only (see element_lanes.hpp).

#include "solver/kernels/forms.hpp"
#include "solver/kernels/series.hpp"

namespace forefeel {
namespace {

// Taylor coefficients 0 .. n - 1 of psi as a function of J alone or of I1 alone, times a weight.
template <class Law, int n>
FOREFEEL_INLINE void taylor(const LawConstants& c, const Point<Lanes>& p, bool of_j, Lanes weight,
                            Lanes* out) {
  Series<Lanes, n> i1, i2, j;
  i1.at[0] = p.i1, i2.at[0] = p.i2, j.at[0] = p.j;
  (of_j ? j : i1).at[1] = spread<Lanes>(1.0);
  const Series<Lanes, n> psi = Law::template terms<Series<Lanes, n>>(c, i1, i2, j).psi;
  for (int k = 0; k < n; ++k) out[k] = weight * psi.at[k];
}

// sum_k c_k (x_1 t + x_2 t^2 + ...)^k: its coefficients of t^4, with x_4 left out, and of t^5.
FOREFEEL_INLINE void add_fourth(const Lanes* c, const Lanes* x1, const Lanes* x2, const Lanes* x3,
                                Lanes* out) {
  Lanes square[6]{}, inner[6]{}, outer[10]{}, half[6]{};
  add_product<1, 1>(x1, x1, square);
  add_scaled<2>(3.0 * c[3], x2, inner);
  add_scaled<2>(c[4], square, inner);
  add_product<1, 2>(x1, inner, outer);
  add_scaled<3>(2.0 * c[2], x3, outer);
  add_product<1, 3>(x1, outer, out);
  add_scaled<2>(c[2], x2, half);
  add_product<2, 2>(half, x2, out);
}
FOREFEEL_INLINE void add_fifth(const Lanes* c, const Lanes* x1, const Lanes* x2, const Lanes* x3,
                               const Lanes* x4, Lanes* out) {
  Lanes square[6]{}, second[6]{}, third[10]{}, fourth[15]{}, half[6]{};
  add_product<1, 1>(x1, x1, square);
  add_scaled<2>(4.0 * c[4], x2, second);
  add_scaled<2>(c[5], square, second);
  add_product<1, 2>(x1, second, third);
  add_scaled<3>(3.0 * c[3], x3, third);
  add_product<1, 3>(x1, third, fourth);
  add_scaled<4>(2.0 * c[2], x4, fourth);
  add_scaled<2>(3.0 * c[3], x2, half);
  add_product<2, 2>(half, x2, fourth);
  add_product<1, 4>(x1, fourth, out);
  Lanes last[6]{};
  add_scaled<2>(2.0 * c[2], x2, last);
  add_product<2, 3>(last, x3, out);
}

// The derivative of that sum by x_1 t + ...: its coefficients of t and t^2, with c_0 to c_3.
FOREFEEL_INLINE void add_derivative(const Lanes* c, const Lanes* x1, const Lanes* x2, Lanes* first,
                                    Lanes* second) {
  add_scaled<1>(2.0 * c[2], x1, first);
  Lanes square[6]{};
  add_product<1, 1>(x1, x1, square);
  add_scaled<2>(2.0 * c[2], x2, second);
  add_scaled<2>(3.0 * c[3], square, second);
}

// J_1 to J_5; before bend, what J_1 to J_3 have of G_1 alone.
struct DeterminantForms {
  Lanes j1[3]{}, j2[6]{}, j3[10]{}, j4[15]{}, j5[21]{}, cof_a[9][6];

  FOREFEEL_INLINE DeterminantForms(const Point<Lanes>& p, MatrixForm<1> a) {
    form_cofactor<1>(a, cof_a);
    add_contraction<0, 1>(constant(p.cof), a, j1);
    add_contraction<0, 2>(constant(p.f), cof_a, j2);
    for (int e = 0; e < 3; ++e) add_product<1, 2>(a[e], cof_a[e], j3);
  }
  FOREFEEL_INLINE void bend(const Point<Lanes>& p, MatrixForm<1> a, MatrixForm<2> b) {
    Lanes mixed[9][3], cof_b[9][15];
    add_contraction<0, 2>(constant(p.cof), b, j2);
    polar_cofactor<0, 1>(constant(p.f), a, mixed);
    add_contraction<1, 2>(mixed, b, j3);
    add_contraction<2, 2>(cof_a, b, j4);
    form_cofactor<2>(b, cof_b);
    add_contraction<0, 4>(constant(p.f), cof_b, j4);
    add_contraction<1, 4>(a, cof_b, j5);
  }
};

// The same of I1, with C_k only if I2 is wanted.
template <bool with_i2>
struct StrainForms {
  Lanes i1[3]{}, i2[6]{}, i3[10]{}, i4[15]{}, c1[6][3], c2[6][6], c3[6][10], c4[6][15];

  FOREFEEL_INLINE StrainForms(const Point<Lanes>& p, MatrixForm<1> a) {
    if constexpr (with_i2) {
      set_square<0, 1, true>(constant(p.f), a, c1);
      set_square<1, 1, false>(a, a, c2);
      add_trace<1>(c1, i1);
      add_trace<2>(c2, i2);
    } else {
      add_contraction<0, 1>(constant(p.f), a, i1);
      add_contraction<1, 1>(a, a, i2);
      for (Lanes& x : i1) x *= 2.0;
    }
  }
  FOREFEEL_INLINE void bend(const Point<Lanes>& p, MatrixForm<1> a, MatrixForm<2> b) {
    if constexpr (with_i2) {
      set_square<0, 2, true, true>(constant(p.f), b, c2);
      set_square<1, 2, true>(a, b, c3);
      set_square<2, 2, false>(b, b, c4);
      for (Lanes& x : i2) x = Lanes{};
      add_trace<2>(c2, i2);
      add_trace<3>(c3, i3);
      add_trace<4>(c4, i4);
    } else {
      Lanes half[6]{};
      add_contraction<0, 2>(constant(p.f), b, half);
      add_scaled<2>(spread<Lanes>(2.0), half, i2);
      add_contraction<1, 2>(a, b, i3);
      add_contraction<2, 2>(b, b, i4);
      for (Lanes& x : i3) x *= 2.0;
    }
  }
};

// The coefficients of t^4 (15) and, with b, t^5 (21) of weight psi along F + t a + t^2 b are added to out.
template <class Law>
__attribute__((noinline)) void path_forms(const LawConstants& c, const Point<Lanes>& p, MatrixForm<1> a,
                                          MatrixForm<2> b, Lanes weight, Lanes* out) {
  Lanes* const fifth = out + 15;
  if constexpr (Law::uses_j) {
    Lanes by_j[6];
    taylor<Law, 6>(c, p, true, weight, by_j);
    DeterminantForms d(p, a);
    add_fourth(by_j, d.j1, d.j2, d.j3, out);
    if (b) {
      d.bend(p, a, b);
      add_fifth(by_j, d.j1, d.j2, d.j3, d.j4, fifth);
      add_scaled<5>(by_j[1], d.j5, fifth);
    }
  }
  if constexpr (Law::uses_i2 || Law::uses_11) {
    Lanes by_i1[6];
    taylor<Law, 6>(c, p, false, weight, by_i1);
    const Lanes by_i2 = weight * p.t.d2;
    StrainForms<Law::uses_i2> s(p, a);
    if constexpr (Law::uses_11) add_fourth(by_i1, s.i1, s.i2, s.i3, out);
    if constexpr (Law::uses_i2) {
      Lanes square[15]{};
      add_product<2, 2>(s.i2, s.i2, square);
      add_scaled<4>(0.5 * by_i2, square, out);
      add_symmetric_contraction<2, 2>(-0.5 * by_i2, s.c2, s.c2, out);
    }
    if (b) {
      s.bend(p, a, b);
      if constexpr (Law::uses_11) add_fifth(by_i1, s.i1, s.i2, s.i3, s.i4, fifth);
      if constexpr (Law::uses_i2) {
        Lanes product[21]{};
        add_product<1, 4>(s.i1, s.i4, product);
        add_product<2, 3>(s.i2, s.i3, product);
        add_scaled<5>(by_i2, product, fifth);
        add_symmetric_contraction<1, 4>(-by_i2, s.c1, s.c4, fifth);
        add_symmetric_contraction<2, 3>(-by_i2, s.c2, s.c3, fifth);
      }
    }
  }
}

// The second Taylor coefficient of weight P along F + a.
template <class Law>
__attribute__((noinline)) void second_stress(const LawConstants& c, const Point<Lanes>& p, MatrixForm<1> a,
                                             Lanes weight, Lanes (*out)[6]) {
  if constexpr (Law::uses_j) {
    Lanes by_j[4], first[3]{}, second[6]{}, mixed[9][3];
    taylor<Law, 4>(c, p, true, weight, by_j);
    const DeterminantForms d(p, a);
    add_derivative(by_j, d.j1, d.j2, first, second);
    polar_cofactor<0, 1>(constant(p.f), a, mixed);
    for (int e = 0; e < 9; ++e) {
      Lanes sum[6]{};
      add_scaled<2>(p.cof[e], second, sum);
      add_product<1, 1>(first, mixed[e], sum);
      add_scaled<2>(by_j[1], d.cof_a[e], sum);
      for (int k = 0; k < 6; ++k) out[e][k] = sum[k];
    }
  }
  if constexpr (Law::uses_i2 || Law::uses_11) {
    Lanes by_i1[4], first[3]{}, second[6]{};
    taylor<Law, 4>(c, p, false, weight, by_i1);
    const StrainForms<Law::uses_i2> s(p, a);
    if constexpr (Law::uses_11) add_derivative(by_i1, s.i1, s.i2, first, second);
    const Lanes by_i2 = weight * p.t.d2;
    if constexpr (Law::uses_i2) {  // dI2/dF = 2 (I1 F - F C)
      add_scaled<1>(by_i2, s.i1, first);
      add_scaled<2>(by_i2, s.i2, second);
    }
    for (int e = 0; e < 9; ++e) {
      Lanes sum[6]{};
      add_scaled<2>(p.f[e], second, sum);
      add_product<1, 1>(first, a[e], sum);
      if constexpr (Law::uses_i2) {
        Lanes product[6]{};
        for (int m = 0; m < 3; ++m) {
          const int row = e / 3 * 3 + m, entry = upper_entry[m][e % 3];
          add_scaled<2>(p.f[row], s.c2[entry], product);
          add_product<1, 1>(a[row], s.c1[entry], product);
        }
        add_scaled<2>(-by_i2, product, sum);
      }
      for (int k = 0; k < 6; ++k) out[e][k] = Law::uses_j ? out[e][k] + 2.0 * sum[k] : 2.0 * sum[k];
    }
  }
}

}  // namespace
}  // namespace forefeel
