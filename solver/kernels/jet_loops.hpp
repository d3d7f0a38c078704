#pragma once
// Loops over elements for energy jets (solver/jet/jet_maker.hpp), compiled once per instruction set.
//   curvature   q = 1/2 d3W/du3 [u_1, u_1, .], a form of degree 2 in d: six fields
//   path        coefficients of t^4 of W(u + t u_1) and of t^5 of W(u + t u_1 + t^2 u_2), forms of degree 4 and 5;
//               u_1 = U d, u_2 = V[d, d]
// Include in kernel files only (see element_lanes.hpp).

#include "solver/kernels/law_forms.hpp"
#include "solver/kernels/stretch_search.hpp"

namespace forefeel {
namespace {

// The gradient of `fields` displacement fields at one quadrature point, without I, as forms.
template <int nodes, int fields>
FOREFEEL_INLINE void field_gradient(const Lanes (*u)[3 * nodes], const Lanes* g, Lanes (*out)[fields]) {
  for (int c = 0; c < fields; ++c)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        Lanes sum = u[c][i] * g[j];
        for (int a = 1; a < nodes; ++a) sum += u[c][3 * a + i] * g[3 * a + j];
        out[3 * i + j][c] = sum;
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

// A group with the displacements of U: fields of JetKernels.
template <int nodes>
struct JetGroup : Group<nodes> {
  Lanes along[3][3 * nodes];

  FOREFEEL_INLINE JetGroup(const ElementView& view, std::int64_t group, const double* fields)
      : Group<nodes>(view, group) {
    for (int b = 0; b < nodes; ++b) {
      Lanes m[2][8];
      for (int e = 0; e < lane_count; ++e) {
        const double* from = fields + jet_row * static_cast<std::int64_t>(this->node[b * lane_count + e]);
        for (int half = 0; half < 2; ++half) m[half][e] = load(from + half * lane_count);
      }
      for (Lanes* half : m) transpose(half);
      for (int i = 0; i < 3; ++i) {
        this->local[3 * b + i] = m[0][i];
        for (int c = 0; c < 3; ++c) along[c][3 * b + i] = m[(3 * c + 3 + i) / 8][(3 * c + 3 + i) % 8];
      }
    }
  }
};

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
void first_order_limit(const ElementView& view, const double* fields, const JetDirections& directions) {
  StretchSearch<Law> search(directions);
  const auto over = [&](std::int64_t group) {
    const JetGroup<nodes> of(view, group, fields);
    Lanes g[3 * nodes], a[9][3];
    for (int point_at = 0; point_at < Shape<nodes>::points; ++point_at) {
      Point<Lanes> point;
      of.template at<Law>(view, point_at, g, point);
      field_gradient<nodes, 3>(of.along, g, a);
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
void curvature_of(const ElementView& view, const double* fields, double* q, const JetDirections& directions) {
  if constexpr (Law::of_invariants) {
    using S = Shape<nodes>;
    for (std::int64_t group = 0; group < view.groups; ++group) {
      const JetGroup<nodes> of(view, group, fields);
      Lanes sum[6][3 * nodes]{}, hard{};
      for (int point_at = 0; point_at < S::points; ++point_at) {
        Lanes g[3 * nodes], a[9][3], p[9][6];
        Point<Lanes> point;
        of.template at<Law>(view, point_at, g, point);
        field_gradient<nodes, 3>(of.along, g, a);
        if constexpr (StretchSearch<Law>::wanted) {
          const Lanes here = StretchSearch<Law>::hardness(point, a);
          hard = here > hard ? here : hard;
        }
        second_stress<Law>(view.constants, point, a, of.weight, p);
        for (int c = 0; c < 6; ++c)
          for (int b = 0; b < nodes; ++b)
            for (int i = 0; i < 3; ++i)
              sum[c][3 * b + i] +=
                  p[3 * i][c] * g[3 * b] + p[3 * i + 1][c] * g[3 * b + 1] + p[3 * i + 2][c] * g[3 * b + 2];
      }
      if (directions.hardness) directions.hardness[group] = largest(hard);
      for (int b = 0; b < nodes; ++b) {
        Lanes by_element[3][8]{};
        for (int i = 0; i < 3; ++i) {
          for (int c = 0; c < 6; ++c) by_element[i][c] = sum[c][3 * b + i];
          transpose(by_element[i]);
        }
        for (int e = 0; e < lane_count; ++e) {
          double* to = q + 3 * lane_count * static_cast<std::int64_t>(of.node[b * lane_count + e]);
          for (int i = 0; i < 3; ++i)
            store(to + i * lane_count, load(to + i * lane_count) + by_element[i][e]);
        }
      }
    }
    if constexpr (StretchSearch<Law>::wanted)
      if (directions.reached) first_order_limit<Law, nodes>(view, fields, directions);
  }
}

// v: null or six fields V_p in lanes, as q of curvature_of.
template <class Law, int nodes>
void path_of(const ElementView& view, const double* fields, const double* v, double* out,
             const JetDirections& directions) {
  if constexpr (Law::of_invariants) {
    constexpr bool limited = StretchSearch<Law>::wanted;
    StretchSearch<Law> search(directions);
    Lanes sums[path_terms]{};
    const auto over = [&](std::int64_t group, bool only_limit) {
      const JetGroup<nodes> of(view, group, fields);
      Lanes second[6][3 * nodes];
      if (v)
        for (int b = 0; b < nodes; ++b) {
          Lanes by_field[3][8];
          for (int e = 0; e < lane_count; ++e) {
            const double* from = v + 3 * lane_count * static_cast<std::int64_t>(of.node[b * lane_count + e]);
            for (int i = 0; i < 3; ++i) by_field[i][e] = load(from + i * lane_count);
          }
          for (int i = 0; i < 3; ++i) {
            transpose(by_field[i]);
            for (int c = 0; c < 6; ++c) second[c][3 * b + i] = by_field[i][c];
          }
        }
      for (int point_at = 0; point_at < Shape<nodes>::points; ++point_at) {
        Lanes g[3 * nodes], a[9][3], bent[9][6];
        Point<Lanes> point;
        of.template at<Law>(view, point_at, g, point);
        field_gradient<nodes, 3>(of.along, g, a);
        if (v) field_gradient<nodes, 6>(second, g, bent);
        const MatrixForm<2> b = v ? bent : nullptr;
        if (!only_limit) path_forms<Law>(view.constants, point, a, b, of.weight, sums);
        if constexpr (limited)
          if (directions.reached && (only_limit || search.may_reach(point, a, b)))
            search.all(point, directions, a, b);
      }
    };
    if (view.groups == 0) return;
    if constexpr (limited)
      if (directions.reached) over(hardest(view, directions), true);
    for (std::int64_t group = 0; group < view.groups; ++group) over(group, false);
    search.give(directions);
    for (int k = 0; k < path_terms; ++k)
      for (int e = 0; e < lane_count; ++e) out[k] += sums[k][e];
  }
}

template <class Law>
struct Jets {
  static void curvature(const ElementView& view, const double* fields, double* q,
                        const JetDirections& directions) {
    view.nodes_per_element == 4 ? curvature_of<Law, 4>(view, fields, q, directions)
                                : curvature_of<Law, 10>(view, fields, q, directions);
  }
  static void path(const ElementView& view, const double* fields, const double* v, double* out,
                   const JetDirections& directions) {
    view.nodes_per_element == 4 ? path_of<Law, 4>(view, fields, v, out, directions)
                                : path_of<Law, 10>(view, fields, v, out, directions);
  }
  static constexpr JetKernels table{curvature, path};
};

}  // namespace
}  // namespace forefeel
