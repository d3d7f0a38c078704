#pragma once
// Loops over elements for one law, compiled once per instruction set (ElementKernels in kernels.hpp):
//   F = I + sum_a u_a (x) G_a     r_a += w P G_a     H_ab += w (dP/dF : (. (x) G_b)) G_a     W = sum w psi
// a, b the element's nodes, G_a [1/m] gradient of a's shape function, w [m^3] volume times quadrature weight.
// Include in kernel files only (see element_lanes.hpp).

#include "solver/kernels/law_terms.hpp"

namespace forefeel {
namespace {

// Gradients of the shape functions at one quadrature point, from those of the barycentric coordinates.
template <int nodes>
struct Shape;

template <>
struct Shape<4> {
  static constexpr int points = 1;
  template <class T>
  static FOREFEEL_INLINE void gradients(int, const T* g, T* out) {
    for (int i = 0; i < 12; ++i) out[i] = g[i];
  }
};

// Quadratic: corners L(2L - 1), then the edges 01 02 03 12 13 23 with 4 La Lb; four points, exact for degree
// two.
template <>
struct Shape<10> {
  static constexpr int points = 4;
  template <class T>
  static FOREFEEL_INLINE void gradients(int point, const T* g, T* out) {
    constexpr double near = 0.58541019662496845446, far = 0.13819660112501051518;
    constexpr int from[6] = {0, 0, 0, 1, 1, 2}, to[6] = {1, 2, 3, 2, 3, 3};
    for (int a = 0; a < 4; ++a) {
      const double weight = 4 * (a == point ? near : far) - 1;
      for (int i = 0; i < 3; ++i) out[3 * a + i] = weight * g[3 * a + i];
    }
    for (int e = 0; e < 6; ++e) {
      const double la = 4 * (from[e] == point ? near : far), lb = 4 * (to[e] == point ? near : far);
      for (int i = 0; i < 3; ++i) out[12 + 3 * e + i] = la * g[3 * to[e] + i] + lb * g[3 * from[e] + i];
    }
  }
};

template <int nodes, class T>
FOREFEEL_INLINE void deformation_gradient(const T* u, const T* g, T* f) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      T sum = spread<T>(i == j ? 1.0 : 0.0);
      for (int a = 0; a < nodes; ++a) sum += u[3 * a + i] * g[3 * a + j];
      f[3 * i + j] = sum;
    }
}

template <int nodes>
FOREFEEL_INLINE void gather(const std::int32_t* node, const double* u, Lanes* out) {
  for (int a = 0; a < nodes; ++a)
    for (int e = 0; e < lane_count; ++e) {
      const double* p = u + 3 * static_cast<std::int64_t>(node[a * lane_count + e]);
      for (int i = 0; i < 3; ++i) out[3 * a + i][e] = p[i];
    }
}

// `size` numbers at the place of a vector, or of its tail (ElementView::row and block). Without a branch, which would
// be guessed wrong again and again.
FOREFEEL_INLINE double* at_place(std::int32_t place, int size, double* vector, double* tail) {
  const std::int64_t in_tail = std::int64_t{place} >> 63;  // all bits, or none
  const auto from = reinterpret_cast<std::int64_t>(vector), to = reinterpret_cast<std::int64_t>(tail);
  return reinterpret_cast<double*>(from ^ ((from ^ to) & in_tail)) + size * (place ^ in_tail);
}

template <int nodes>
FOREFEEL_INLINE void scatter(const std::int32_t* row, const Lanes* sum, double* r, double* tail) {
  for (int e = 0; e < lane_count; ++e)
    for (int a = 0; a < nodes; ++a) {
      double* to = at_place(row[a * lane_count + e], 3, r, tail);
      for (int i = 0; i < 3; ++i) to[i] += sum[3 * a + i][e];
    }
}

// Eight elements: their nodes, displacements and weight w.
template <int nodes>
struct Group {
  const std::int32_t* node;
  Lanes rest[12], local[3 * nodes], weight;

  FOREFEEL_INLINE Group(const ElementView& view, std::int64_t group)
      : node(view.node + group * nodes * lane_count) {
    for (int i = 0; i < 12; ++i) rest[i] = load(view.gradient + (group * 12 + i) * lane_count);
    weight = load(view.volume + group * lane_count) * (1.0 / Shape<nodes>::points);
  }
  FOREFEEL_INLINE Group(const ElementView& view, std::int64_t group, const double* u) : Group(view, group) {
    gather<nodes>(node, u, local);
  }
  // The gradients of the shape functions and the material at quadrature point q.
  template <class Law>
  FOREFEEL_INLINE void at(const ElementView& view, int q, Lanes* g, Point<Lanes>& point) const {
    Shape<nodes>::gradients(q, rest, g);
    deformation_gradient<nodes>(local, g, point.f);
    prepare<Law>(view.constants, point);
  }
};

template <class Law, int nodes>
FieldSummary gradient_of(const ElementView& view, const double* u, double* r) {
  using S = Shape<nodes>;
  Lanes energy{}, lowest = spread<Lanes>(__builtin_inf());
  for (std::int64_t group = 0; group < view.groups; ++group) {
    const Group<nodes> of(view, group, u);
    Lanes sum[3 * nodes]{};
    for (int q = 0; q < S::points; ++q) {
      Lanes g[3 * nodes], p[9];
      Point<Lanes> point;
      of.template at<Law>(view, q, g, point);
      stress<Law>(view.constants, point, p);
      energy += of.weight * point.t.psi;
      lowest = least(lowest, point.j);
      for (int i = 0; i < 9; ++i) p[i] *= of.weight;
      for (int a = 0; a < nodes; ++a)
        for (int i = 0; i < 3; ++i)
          sum[3 * a + i] += p[3 * i] * g[3 * a] + p[3 * i + 1] * g[3 * a + 1] + p[3 * i + 2] * g[3 * a + 2];
    }
    scatter<nodes>(view.row + group * nodes * lane_count, sum, r, view.tail);
  }
  FieldSummary summary;
  summary.min_jacobian = __builtin_inf();
  for (int e = 0; e < lane_count; ++e) {
    summary.energy += energy[e];
    summary.min_jacobian = least(summary.min_jacobian, lowest[e]);
  }
  if (Law::needs_positive_j && !(summary.min_jacobian > 0)) summary.energy = __builtin_inf();
  return summary;
}

template <class Law, int nodes>
void hessian_of(const ElementView& view, const double* u, double* blocks) {
  using S = Shape<nodes>;
  constexpr int pairs = nodes * (nodes + 1) / 2;
  for (std::int64_t group = 0; group < view.groups; ++group) {
    const Group<nodes> of(view, group, u);
    Lanes h[9 * pairs]{};
    for (int q = 0; q < S::points; ++q) {
      Lanes g[3 * nodes];
      Point<Lanes> point;
      of.template at<Law>(view, q, g, point);
      for (int b = 0; b < nodes; ++b)
        for (int k = 0; k < 3; ++k) {
          Lanes d[9]{}, p[9];
          for (int j = 0; j < 3; ++j) d[3 * k + j] = g[3 * b + j];
          stress_change<Law>(view.constants, point, d, p);
          for (int i = 0; i < 9; ++i) p[i] *= of.weight;
          for (int a = 0; a <= b; ++a)
            for (int i = 0; i < 3; ++i)
              h[9 * (b * (b + 1) / 2 + a) + 3 * i + k] +=
                  p[3 * i] * g[3 * a] + p[3 * i + 1] * g[3 * a + 1] + p[3 * i + 2] * g[3 * a + 2];
        }
    }
    const std::int32_t* block = view.block + group * pairs * lane_count;
    const std::int8_t* kind = view.block_kind + group * pairs * lane_count;
    for (int pair = 0; pair < pairs; ++pair)
      for (int e = 0; e < lane_count; ++e) {
        double* to = at_place(block[pair * lane_count + e], 9, blocks, view.tail);
        const int how = kind[pair * lane_count + e];
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k) {
            const double value = h[9 * pair + 3 * i + k][e];
            if (how != 1) to[3 * i + k] += value;
            if (how != 0) to[3 * k + i] += value;
          }
      }
  }
}

template <class Law, int nodes>
void product_of(const ElementView& view, std::int64_t stride, const double* u, const double* d, double* y) {
  using S = Shape<nodes>;
  for (std::int64_t group = 0; group < view.groups; ++group) {
    const Group<nodes> of(view, group, u);
    Lanes along[3][3 * nodes], sum[3][3 * nodes]{};
    for (int c = 0; c < 3; ++c) gather<nodes>(of.node, d + c * stride, along[c]);
    for (int q = 0; q < S::points; ++q) {
      Lanes g[3 * nodes];
      Point<Lanes> point;
      of.template at<Law>(view, q, g, point);
      for (int c = 0; c < 3; ++c) {
        Lanes df[9], p[9];
        deformation_gradient<nodes>(along[c], g, df);
        for (int i = 0; i < 3; ++i) df[4 * i] -= 1.0;
        stress_change<Law>(view.constants, point, df, p);
        for (int i = 0; i < 9; ++i) p[i] *= of.weight;
        for (int a = 0; a < nodes; ++a)
          for (int i = 0; i < 3; ++i)
            sum[c][3 * a + i] +=
                p[3 * i] * g[3 * a] + p[3 * i + 1] * g[3 * a + 1] + p[3 * i + 2] * g[3 * a + 2];
      }
    }
    for (int c = 0; c < 3; ++c)
      scatter<nodes>(view.row + group * nodes * lane_count, sum[c], y + c * stride,
                     view.tail + c * view.tail_stride);
  }
}

template <class Law, int nodes>
void gradient_lanes_of(const ElementView& view, const double* u, double* r, double* energy,
                       double* min_jacobian) {
  using S = Shape<nodes>;
  Lanes total{}, lowest = spread<Lanes>(__builtin_inf());
  for (std::int64_t group = 0; group < view.groups; ++group)
    for (int e = 0; e < lane_count; ++e) {
      const std::int32_t* node = view.node + group * nodes * lane_count + e;
      const double volume = view.volume[group * lane_count + e];
      if (volume == 0) continue;
      double rest[12];
      for (int i = 0; i < 12; ++i) rest[i] = view.gradient[(group * 12 + i) * lane_count + e];
      Lanes local[3 * nodes], sum[3 * nodes]{};
      for (int a = 0; a < nodes; ++a)
        for (int i = 0; i < 3; ++i)
          local[3 * a + i] = load(u + (3 * static_cast<std::int64_t>(node[a * lane_count]) + i) * lane_count);
      for (int q = 0; q < S::points; ++q) {
        double g[3 * nodes];
        S::gradients(q, rest, g);
        Point<Lanes> point;
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) {
            Lanes f = spread<Lanes>(i == j ? 1.0 : 0.0);
            for (int a = 0; a < nodes; ++a) f += local[3 * a + i] * g[3 * a + j];
            point.f[3 * i + j] = f;
          }
        Lanes p[9];
        prepare<Law>(view.constants, point);
        stress<Law>(view.constants, point, p);
        const double weight = volume / S::points;
        total += weight * point.t.psi;
        lowest = least(lowest, point.j);
        for (int a = 0; a < nodes; ++a) {
          const double ga = weight * g[3 * a], gb = weight * g[3 * a + 1], gc = weight * g[3 * a + 2];
          for (int i = 0; i < 3; ++i) sum[3 * a + i] += p[3 * i] * ga + p[3 * i + 1] * gb + p[3 * i + 2] * gc;
        }
      }
      const std::int32_t* row = view.row + group * nodes * lane_count + e;
      for (int a = 0; a < nodes; ++a)
        for (int i = 0; i < 3; ++i) {
          double* to = at_place(row[a * lane_count], 3 * lane_count, r, view.tail) + i * lane_count;
          store(to, load(to) + sum[3 * a + i]);
        }
    }
  for (int e = 0; e < lane_count; ++e) {
    energy[e] = Law::needs_positive_j && !(lowest[e] > 0) ? __builtin_inf() : total[e];
    min_jacobian[e] = lowest[e];
  }
}

template <class Law, int nodes>
void product_lanes_of(const ElementView& view, std::int64_t stride, const double* u, const double* d,
                      double* y) {
  using S = Shape<nodes>;
  for (std::int64_t group = 0; group < view.groups; ++group)
    for (int e = 0; e < lane_count; ++e) {
      const std::int32_t* node = view.node + group * nodes * lane_count + e;
      const std::int32_t* row = view.row + group * nodes * lane_count + e;
      const double volume = view.volume[group * lane_count + e];
      if (volume == 0) continue;
      double rest[12];
      for (int i = 0; i < 12; ++i) rest[i] = view.gradient[(group * 12 + i) * lane_count + e];
      for (int q = 0; q < S::points; ++q) {
        double g[3 * nodes];
        S::gradients(q, rest, g);
        Point<Lanes> point;
        for (int i = 0; i < 9; ++i) point.f[i] = spread<Lanes>(i % 4 == 0 ? 1.0 : 0.0);
        for (int a = 0; a < nodes; ++a)
          for (int i = 0; i < 3; ++i) {
            const Lanes v = load(u + (3 * static_cast<std::int64_t>(node[a * lane_count]) + i) * lane_count);
            for (int j = 0; j < 3; ++j) point.f[3 * i + j] += v * g[3 * a + j];
          }
        prepare<Law>(view.constants, point);
        const double weight = volume / S::points;
        for (int c = 0; c < 3; ++c) {
          Lanes df[9]{}, p[9];
          for (int a = 0; a < nodes; ++a)
            for (int i = 0; i < 3; ++i) {
              const std::int64_t at = (3 * static_cast<std::int64_t>(node[a * lane_count]) + i) * lane_count;
              const Lanes v = load(d + c * stride + at);
              for (int j = 0; j < 3; ++j) df[3 * i + j] += v * g[3 * a + j];
            }
          stress_change<Law>(view.constants, point, df, p);
          for (int a = 0; a < nodes; ++a) {
            const double ga = weight * g[3 * a], gb = weight * g[3 * a + 1], gc = weight * g[3 * a + 2];
            for (int i = 0; i < 3; ++i) {
              double* to = at_place(row[a * lane_count], 3 * lane_count, y + c * stride,
                                    view.tail + c * view.tail_stride) +
                           i * lane_count;
              store(to, load(to) + p[3 * i] * ga + p[3 * i + 1] * gb + p[3 * i + 2] * gc);
            }
          }
        }
      }
    }
}

template <class Law>
struct Both {
  static FieldSummary gradient(const ElementView& view, const double* u, double* r) {
    return view.nodes_per_element == 4 ? gradient_of<Law, 4>(view, u, r) : gradient_of<Law, 10>(view, u, r);
  }
  static void hessian(const ElementView& view, const double* u, double* blocks) {
    view.nodes_per_element == 4 ? hessian_of<Law, 4>(view, u, blocks) : hessian_of<Law, 10>(view, u, blocks);
  }
  static void gradient_lanes(const ElementView& view, const double* u, double* r, double* energy,
                             double* least_j) {
    view.nodes_per_element == 4 ? gradient_lanes_of<Law, 4>(view, u, r, energy, least_j)
                                : gradient_lanes_of<Law, 10>(view, u, r, energy, least_j);
  }
  static void product(const ElementView& view, std::int64_t stride, const double* u, const double* d,
                      double* y) {
    view.nodes_per_element == 4 ? product_of<Law, 4>(view, stride, u, d, y)
                                : product_of<Law, 10>(view, stride, u, d, y);
  }
  static void product_lanes(const ElementView& view, std::int64_t stride, const double* u, const double* d,
                            double* y) {
    view.nodes_per_element == 4 ? product_lanes_of<Law, 4>(view, stride, u, d, y)
                                : product_lanes_of<Law, 10>(view, stride, u, d, y);
  }
  static constexpr ElementKernels table{gradient, hessian, gradient_lanes, product, product_lanes};
};

}  // namespace
}  // namespace forefeel
