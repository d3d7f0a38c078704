#pragma once
// Loops over elements for energy jets (solver/jet/jet_maker.hpp), compiled once per instruction set.
//   curvature   q_p += 1/2 d3W/du3 [U_i, U_j, .], mixed pairs twice: the second Taylor coefficient of dW/du along
//               u + U d is sum_p q_p d_i d_j, p = 11 22 33 12 13 23
//   path        coefficients of t^4 and t^5 of W(u + t u_1 + t^2 u_2), u_1 = U d, u_2 = sum_p V_p d_i d_j
// F(t) = F + t G_1 + t^2 G_2 with G_k the gradients of u_k. With cof the cofactor and X(A, B) its polar form, cof(A +
// B) = cof A + X(A, B) + cof B:
//   cof F(t) = cof F + t X(F, G_1) + t^2 (cof G_1 + X(F, G_2)) + t^3 X(G_1, G_2) + t^4 cof G_2
//   J(t)     = 1/3 cof F(t) : F(t)        I2(t) = |cof F(t)|^2        I1(t) = |F(t)|^2
// Include in kernel files only (see element_lanes.hpp).

#include "solver/kernels/series.hpp"
#include "solver/kernels/stretch_search.hpp"

namespace forefeel {
namespace {

// X(a, b), given the cofactors of both.
FOREFEEL_INLINE void polar_cofactor(const Lanes* a, const Lanes* cof_a, const Lanes* b, const Lanes* cof_b,
                                    Lanes* out) {
  Lanes sum[9];
  for (int i = 0; i < 9; ++i) sum[i] = a[i] + b[i];
  cofactor(sum, out);
  for (int i = 0; i < 9; ++i) out[i] -= cof_a[i] + cof_b[i];
}

// The gradient of a displacement field at one quadrature point, without I.
template <int nodes>
FOREFEEL_INLINE void field_gradient(const Lanes* u, const Lanes* g, Lanes* out) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      Lanes sum = u[i] * g[j];
      for (int a = 1; a < nodes; ++a) sum += u[3 * a + i] * g[3 * a + j];
      out[3 * i + j] = sum;
    }
}

// The second Taylor coefficient of P along F + t a.
template <class Law>
FOREFEEL_INLINE void second_stress(const LawConstants& c, const Point<Lanes>& p, const Lanes* a, Lanes* out) {
  using Quadratic = Series<Lanes, 3>;
  const Lanes* f = p.f;
  Lanes cof_a[9], mixed[9];
  if constexpr (Law::uses_j || Law::uses_i2) {
    cofactor(a, cof_a);
    polar_cofactor(f, p.cof, a, cof_a, mixed);
  }
  Quadratic i1, i2, j;
  i1.at[0] = p.i1, i1.at[1] = 2.0 * dot9(f, a), i1.at[2] = dot9(a, a);
  if constexpr (Law::uses_i2) {
    i2.at[0] = p.i2, i2.at[1] = 2.0 * dot9(p.cof, mixed);
    i2.at[2] = dot9(mixed, mixed) + 2.0 * dot9(p.cof, cof_a);
  }
  if constexpr (Law::uses_j) j.at[0] = p.j, j.at[1] = dot9(p.cof, a), j.at[2] = dot9(f, cof_a);
  const Terms<Quadratic> t = Law::template terms<Quadratic>(c, i1, i2, j);
  for (int i = 0; i < 9; ++i) out[i] = 2.0 * (t.d1.at[2] * f[i] + t.d1.at[1] * a[i]);
  if constexpr (Law::uses_j)
    for (int i = 0; i < 9; ++i)
      out[i] += t.dj.at[2] * p.cof[i] + t.dj.at[1] * mixed[i] + t.dj.at[0] * cof_a[i];
  if constexpr (Law::uses_i2) {
    // dI2/dF = 2 (I1 F - F C): coefficients s0, s1, s2 along the path.
    Lanes c1[9], c2[9];
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        c1[3 * i + k] = f[i] * a[k] + f[3 + i] * a[3 + k] + f[6 + i] * a[6 + k] + a[i] * f[k] +
                        a[3 + i] * f[3 + k] + a[6 + i] * f[6 + k];
        c2[3 * i + k] = a[i] * a[k] + a[3 + i] * a[3 + k] + a[6 + i] * a[6 + k];
      }
    const auto times = [](const Lanes* x, const Lanes* y, int i, int k) {
      return x[3 * i] * y[k] + x[3 * i + 1] * y[3 + k] + x[3 * i + 2] * y[6 + k];
    };
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        const int at = 3 * i + k;
        const Lanes s0 = i1.at[0] * f[at] - times(f, p.c, i, k);
        const Lanes s1 = i1.at[1] * f[at] + i1.at[0] * a[at] - times(a, p.c, i, k) - times(f, c1, i, k);
        const Lanes s2 = i1.at[2] * f[at] + i1.at[1] * a[at] - times(a, c1, i, k) - times(f, c2, i, k);
        out[at] += 2.0 * (t.d2.at[0] * s2 + t.d2.at[1] * s1 + t.d2.at[2] * s0);
      }
  }
}

// Eight vectors as the columns of a matrix become its rows.
FOREFEEL_INLINE void transpose(Lanes* m) {
  Lanes t[8];
  for (int i = 0; i < 8; i += 2) {
    t[i] = __builtin_shufflevector(m[i], m[i + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    t[i + 1] = __builtin_shufflevector(m[i], m[i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (int i = 0; i < 8; i += 4)
    for (int k = 0; k < 2; ++k) {
      m[i + k] = __builtin_shufflevector(t[i + k], t[i + k + 2], 0, 1, 8, 9, 4, 5, 12, 13);
      m[i + k + 2] = __builtin_shufflevector(t[i + k], t[i + k + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  for (int i = 0; i < 4; ++i) {
    t[i] = __builtin_shufflevector(m[i], m[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    t[i + 4] = __builtin_shufflevector(m[i], m[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
  for (int i = 0; i < 8; ++i) m[i] = t[i];
}

FOREFEEL_INLINE double largest(Lanes a) {
  double most = a[0];
  for (int e = 1; e < lane_count; ++e) most = a[e] > most ? a[e] : most;
  return most;
}

// The group whose elements are nearest to the limit.
inline std::int64_t hardest(const ElementView& view, const JetDirections& directions) {
  std::int64_t most = 0;
  for (std::int64_t group = 1; group < view.groups; ++group)
    if (directions.hardness[group] > directions.hardness[most]) most = group;
  return most;
}

// The limit without V. The hardest group first: few others can then be nearer.
template <class Law, int nodes>
void first_order_limit(const ElementView& view, std::int64_t stride, const double* u, const double* d,
                       const JetDirections& directions) {
  StretchSearch<Law> search(directions);
  const auto over = [&](std::int64_t group) {
    const Group<nodes> of(view, group, u);
    Lanes along[3][3 * nodes], g[3 * nodes], a[3][9];
    for (int c = 0; c < 3; ++c) gather<nodes>(of.node, d + c * stride, along[c]);
    for (int point_at = 0; point_at < Shape<nodes>::points; ++point_at) {
      Point<Lanes> point;
      of.template at<Law>(view, point_at, g, point);
      for (int c = 0; c < 3; ++c) field_gradient<nodes>(along[c], g, a[c]);
      search.all(point, directions, a, nullptr);
    }
  };
  if (view.groups == 0) return;
  const std::int64_t first = hardest(view, directions);
  over(first);
  for (std::int64_t group = 0; group < view.groups; ++group)
    if (group != first && directions.hardness[group] * search.reached * search.reached > 1) over(group);
  search.give(directions);
}

template <class Law, int nodes>
void curvature_of(const ElementView& view, std::int64_t stride, const double* u, const double* d, double* q,
                  const JetDirections& directions) {
  if constexpr (Law::of_invariants) {
    using S = Shape<nodes>;
    for (std::int64_t group = 0; group < view.groups; ++group) {
      const Group<nodes> of(view, group, u);
      Lanes along[3][3 * nodes], sum[6][3 * nodes]{}, hard{};
      for (int c = 0; c < 3; ++c) gather<nodes>(of.node, d + c * stride, along[c]);
      for (int point_at = 0; point_at < S::points; ++point_at) {
        Lanes g[3 * nodes], a[6][9], p[6][9];
        Point<Lanes> point;
        of.template at<Law>(view, point_at, g, point);
        for (int c = 0; c < 3; ++c) field_gradient<nodes>(along[c], g, a[c]);
        if constexpr (StretchSearch<Law>::wanted) {
          const Lanes here = StretchSearch<Law>::hardness(point, a);
          hard = here > hard ? here : hard;
        }
        for (int c = 3; c < 6; ++c)
          for (int i = 0; i < 9; ++i) a[c][i] = a[pair_from[c]][i] + a[pair_to[c]][i];
        for (int c = 0; c < 6; ++c) second_stress<Law>(view.constants, point, a[c], p[c]);
        for (int c = 3; c < 6; ++c)
          for (int i = 0; i < 9; ++i) p[c][i] -= p[pair_from[c]][i] + p[pair_to[c]][i];
        for (int c = 0; c < 6; ++c) {
          for (int i = 0; i < 9; ++i) p[c][i] *= of.weight;
          for (int b = 0; b < nodes; ++b)
            for (int i = 0; i < 3; ++i)
              sum[c][3 * b + i] +=
                  p[c][3 * i] * g[3 * b] + p[c][3 * i + 1] * g[3 * b + 1] + p[c][3 * i + 2] * g[3 * b + 2];
        }
      }
      if (directions.hardness) directions.hardness[group] = largest(hard);
      for (int b = 0; b < nodes; ++b)
        for (int i = 0; i < 3; ++i) {
          Lanes by_element[8]{};
          for (int c = 0; c < 6; ++c) by_element[c] = sum[c][3 * b + i];
          transpose(by_element);
          for (int e = 0; e < lane_count; ++e) {
            double* to = q + lane_count * (3 * static_cast<std::int64_t>(of.node[b * lane_count + e]) + i);
            store(to, load(to) + by_element[e]);
          }
        }
    }
    if constexpr (StretchSearch<Law>::wanted)
      if (directions.reached) first_order_limit<Law, nodes>(view, stride, u, d, directions);
  }
}

// psi along F + t g1 + t^2 g2: its coefficients of t^4 and t^5 are added to out.
template <class Law>
FOREFEEL_INLINE void path_terms(const LawConstants& c, const Point<Lanes>& p, const Lanes* g1,
                                const Lanes* g2, Lanes weight, Lanes* out) {
  if constexpr (!Law::of_invariants) {
    Lanes f[9];
    for (int i = 0; i < 9; ++i) f[i] = g2[i] + (i % 4 == 0 ? 1.0 : 0.0);
    out[0] += weight * Law::template energy<Lanes>(c, f);  // quadratic in F - I
  } else {
    using Quintic = Series<Lanes, 6>;
    Lanes cof1[9], cof2[9], mixed[9];
    if constexpr (Law::uses_j || Law::uses_i2) {
      cofactor(g1, cof1);
      cofactor(g2, cof2);
      polar_cofactor(p.f, p.cof, g1, cof1, mixed);
    }
    Quintic i1, i2, j;
    i1.at[0] = p.i1, i1.at[1] = 2.0 * dot9(p.f, g1), i1.at[2] = 2.0 * dot9(p.f, g2) + dot9(g1, g1);
    i1.at[3] = 2.0 * dot9(g1, g2), i1.at[4] = dot9(g2, g2);
    if constexpr (Law::uses_i2) {
      Lanes k2[9], k3[9];
      polar_cofactor(p.f, p.cof, g2, cof2, k2);
      for (int i = 0; i < 9; ++i) k2[i] += cof1[i];
      polar_cofactor(g1, cof1, g2, cof2, k3);
      i2.at[0] = p.i2, i2.at[1] = 2.0 * dot9(p.cof, mixed);
      i2.at[2] = 2.0 * dot9(p.cof, k2) + dot9(mixed, mixed);
      i2.at[3] = 2.0 * (dot9(p.cof, k3) + dot9(mixed, k2));
      i2.at[4] = 2.0 * (dot9(p.cof, cof2) + dot9(mixed, k3)) + dot9(k2, k2);
      i2.at[5] = 2.0 * (dot9(mixed, cof2) + dot9(k2, k3));
    }
    if constexpr (Law::uses_j) {
      j.at[0] = p.j, j.at[1] = dot9(p.cof, g1), j.at[2] = dot9(p.cof, g2) + dot9(p.f, cof1);
      j.at[3] = dot9(mixed, g2) + (1.0 / 3) * dot9(cof1, g1);
      j.at[4] = dot9(cof1, g2) + dot9(p.f, cof2), j.at[5] = dot9(cof2, g1);
    }
    const Quintic psi = Law::template terms<Quintic>(c, i1, i2, j).psi;
    out[0] += weight * psi.at[4];
    out[1] += weight * psi.at[5];
  }
}

// v: null (u_2 = 0) or six fields V_p in lanes, as q of curvature_of; out: directions x 2.
template <class Law, int nodes>
void path_of(const ElementView& view, std::int64_t stride, const double* u, const double* tangent,
             const double* v, double* out, const JetDirections& directions) {
  constexpr bool limited = StretchSearch<Law>::wanted;
  StretchSearch<Law> search(directions);
  Lanes sums[2 * most_directions]{};
  const auto over = [&](std::int64_t group, bool only_limit) {
    const Group<nodes> of(view, group, u);
    Lanes first[3][3 * nodes], second[6][3 * nodes]{};
    for (int c = 0; c < 3; ++c) gather<nodes>(of.node, tangent + c * stride, first[c]);
    if (v)
      for (int b = 0; b < nodes; ++b)
        for (int i = 0; i < 3; ++i) {
          Lanes by_field[8];
          for (int e = 0; e < lane_count; ++e)
            by_field[e] =
                load(v + lane_count * (3 * static_cast<std::int64_t>(of.node[b * lane_count + e]) + i));
          transpose(by_field);
          for (int c = 0; c < 6; ++c) second[c][3 * b + i] = by_field[c];
        }
    for (int point_at = 0; point_at < Shape<nodes>::points; ++point_at) {
      Lanes g[3 * nodes], a[3][9], b[6][9]{};
      Point<Lanes> point;
      of.template at<Law>(view, point_at, g, point);
      for (int c = 0; c < 3; ++c) field_gradient<nodes>(first[c], g, a[c]);
      if (v)
        for (int c = 0; c < 6; ++c) field_gradient<nodes>(second[c], g, b[c]);
      if (only_limit) {
        if constexpr (limited) search.all(point, directions, a, b);
        continue;
      }
      for (int k = 0; k < directions.count; ++k) {
        Lanes g1[9], g2[9];
        along_way(directions.ways + 3 * k, a, b, g1, g2);
        path_terms<Law>(view.constants, point, g1, g2, of.weight, sums + 2 * k);
      }
      if constexpr (limited)
        if (directions.reached && search.may_reach(point, a, b)) search.all(point, directions, a, b);
    }
  };
  if (view.groups == 0) return;
  if constexpr (limited)
    if (directions.reached) over(hardest(view, directions), true);
  for (std::int64_t group = 0; group < view.groups; ++group) over(group, false);
  search.give(directions);
  for (int k = 0; k < 2 * directions.count; ++k)
    for (int e = 0; e < lane_count; ++e) out[k] += sums[k][e];
}

template <class Law>
struct Jets {
  static void curvature(const ElementView& view, std::int64_t stride, const double* u, const double* d,
                        double* q, const JetDirections& directions) {
    view.nodes_per_element == 4 ? curvature_of<Law, 4>(view, stride, u, d, q, directions)
                                : curvature_of<Law, 10>(view, stride, u, d, q, directions);
  }
  static void path(const ElementView& view, std::int64_t stride, const double* u, const double* tangent,
                   const double* v, double* out, const JetDirections& directions) {
    view.nodes_per_element == 4 ? path_of<Law, 4>(view, stride, u, tangent, v, out, directions)
                                : path_of<Law, 10>(view, stride, u, tangent, v, out, directions);
  }
  static constexpr JetKernels table{curvature, path};
};

}  // namespace
}  // namespace forefeel
