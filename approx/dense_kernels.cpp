#include "approx/dense_kernels.hpp"

#include <cmath>

#include "geometry/simd.hpp"

#define FOREFEEL_INLINE static inline __attribute__((always_inline))

namespace forefeel::dense {
namespace {

// Unaligned vectors; the compiler splits them where the processor's are shorter.
typedef double Pack8 __attribute__((vector_size(64), aligned(8), may_alias));

// By name, as a template argument a type loses its attributes.
struct Four {
  typedef double Pack __attribute__((vector_size(32), aligned(8), may_alias));
  static constexpr std::size_t size = 4;
};
struct Eight {
  typedef double Pack __attribute__((vector_size(64), aligned(8), may_alias));
  static constexpr std::size_t size = 8;
};

constexpr std::size_t width = 6;  // columns that a panel solve holds in registers

template <class Lanes>
FOREFEEL_INLINE void solve_panel(const double* __restrict l, std::size_t stride,
                                 const double* __restrict inverse, std::size_t m, double* __restrict x) {
  typedef typename Lanes::Pack Pack;
  constexpr std::size_t P = Lanes::size;
  for (std::size_t c = 0; c < m; c += width) {
    Pack sum[width] = {};
    const double* __restrict row = l + c;
    for (std::size_t j = 0; j < c; ++j, row += stride) {
      const Pack xj = *reinterpret_cast<const Pack*>(x + j * P);
      for (std::size_t t = 0; t < width; ++t) sum[t] += xj * row[t];
    }
    for (std::size_t t = 0; t < width && c + t < m; ++t) {
      Pack value = *reinterpret_cast<const Pack*>(x + (c + t) * P) - sum[t];
      for (std::size_t s = 0; s < t; ++s)
        value -= *reinterpret_cast<const Pack*>(x + (c + s) * P) * l[(c + s) * stride + c + t];
      *reinterpret_cast<Pack*>(x + (c + t) * P) = value * inverse[c + t];
    }
  }
}

template <class Lanes>
FOREFEEL_INLINE void products(const double* __restrict x, const double* __restrict y, std::size_t stride,
                              std::size_t m, int halves, double* __restrict gram, double* __restrict side) {
  typedef typename Lanes::Pack Pack;
  constexpr std::size_t P = Lanes::size;
  Pack g[P] = {};
  for (std::size_t c = 0; c < m; ++c) {
    const Pack xc = *reinterpret_cast<const Pack*>(x + c * P);
    for (std::size_t t = 0; t < P; ++t) g[t] += xc * x[c * P + t];
  }
  for (std::size_t t = 0; t < P; ++t) *reinterpret_cast<Pack*>(gram + t * P) = g[t];
  for (int h = 0; h < halves; ++h) {
    Pack8 s[P] = {};
    const double* __restrict yc = y + 8 * h;
    for (std::size_t c = 0; c < m; ++c, yc += stride) {
      const Pack8 value = *reinterpret_cast<const Pack8*>(yc);
      for (std::size_t t = 0; t < P; ++t) s[t] += value * x[c * P + t];
    }
    for (std::size_t t = 0; t < P; ++t) *reinterpret_cast<Pack8*>(side + t * 16 + 8 * h) = s[t];
  }
}

// Lane numbers, to leave alone the first lanes of a vector that starts before the first row meant.
typedef long long Lanes8 __attribute__((vector_size(64)));
constexpr Lanes8 lane = {0, 1, 2, 3, 4, 5, 6, 7};

FOREFEEL_INLINE void rotation(double diagonal, double x, double& c, double& s, double& r) {
  r = std::sqrt(diagonal * diagonal + x * x);
  c = diagonal / r;
  s = x / r;
}

// One vector, four columns at a time: the vector stays in registers while four columns stream by.
FOREFEEL_INLINE void rotate_one(double* __restrict l, std::size_t stride, double* __restrict inverse,
                                std::size_t first, std::size_t last, std::size_t m, double* __restrict v) {
  std::size_t col = first;
  for (; col + 4 <= last; col += 4) {
    double c[4], s[4];
    double* __restrict base[4];
    for (int t = 0; t < 4; ++t) {
      base[t] = l + (col + t) * stride;
      double r;
      rotation(base[t][col + t], v[col + t], c[t], s[t], r);
      base[t][col + t] = r;
      inverse[col + t] = 1 / r;
      for (std::size_t i = col + t + 1; i < col + 4; ++i) {
        const double old = base[t][i];
        base[t][i] = c[t] * old + s[t] * v[i];
        v[i] = c[t] * v[i] - s[t] * old;
      }
    }
    double* __restrict b0 = base[0];
    double* __restrict b1 = base[1];
    double* __restrict b2 = base[2];
    double* __restrict b3 = base[3];
    const auto sweep = [&](std::ptrdiff_t i) __attribute__((always_inline)) {
      Pack8 x = *reinterpret_cast<Pack8*>(v + i);
      const Pack8 l0 = *reinterpret_cast<Pack8*>(b0 + i), l1 = *reinterpret_cast<Pack8*>(b1 + i);
      const Pack8 l2 = *reinterpret_cast<Pack8*>(b2 + i), l3 = *reinterpret_cast<Pack8*>(b3 + i);
      *reinterpret_cast<Pack8*>(b0 + i) = c[0] * l0 + s[0] * x;
      x = c[0] * x - s[0] * l0;
      *reinterpret_cast<Pack8*>(b1 + i) = c[1] * l1 + s[1] * x;
      x = c[1] * x - s[1] * l1;
      *reinterpret_cast<Pack8*>(b2 + i) = c[2] * l2 + s[2] * x;
      x = c[2] * x - s[2] * l2;
      *reinterpret_cast<Pack8*>(b3 + i) = c[3] * l3 + s[3] * x;
      *reinterpret_cast<Pack8*>(v + i) = c[3] * x - s[3] * l3;
    };
    sweep(-16);
    sweep(-8);
    const std::size_t start = (col + 4) / 8 * 8;
    if (start < m) {  // the vector that holds row col + 4; lanes before it stay
      Pack8* at[5] = {reinterpret_cast<Pack8*>(b0 + start), reinterpret_cast<Pack8*>(b1 + start),
                      reinterpret_cast<Pack8*>(b2 + start), reinterpret_cast<Pack8*>(b3 + start),
                      reinterpret_cast<Pack8*>(v + start)};
      const Pack8 old[5] = {*at[0], *at[1], *at[2], *at[3], *at[4]};
      const auto below = lane >= static_cast<long long>(col + 4 - start);
      sweep(static_cast<std::ptrdiff_t>(start));
      for (int t = 0; t < 5; ++t) *at[t] = below ? *at[t] : old[t];
    }
    for (std::size_t i = start + 8; i < m; i += 8) sweep(static_cast<std::ptrdiff_t>(i));
  }
  for (; col < last; ++col) {
    double* __restrict b = l + col * stride;
    double c, s, r;
    rotation(b[col], v[col], c, s, r);
    b[col] = r;
    inverse[col] = 1 / r;
    const auto sweep = [&](std::ptrdiff_t i) __attribute__((always_inline)) {
      const Pack8 x = *reinterpret_cast<Pack8*>(v + i);
      const Pack8 old = *reinterpret_cast<Pack8*>(b + i);
      *reinterpret_cast<Pack8*>(b + i) = c * old + s * x;
      *reinterpret_cast<Pack8*>(v + i) = c * x - s * old;
    };
    sweep(-16);
    sweep(-8);
    for (std::size_t i = col + 1; i < m; i += 8) sweep(static_cast<std::ptrdiff_t>(i));
  }
}

// Several vectors, one column at a time: the column is read and written once.
template <int V>
FOREFEEL_INLINE void rotate_many(double* __restrict l, std::size_t stride, double* __restrict inverse,
                                 std::size_t first, std::size_t last, std::size_t m, double* __restrict v,
                                 std::size_t vs) {
  for (std::size_t col = first; col < last; ++col) {
    double* __restrict b = l + col * stride;
    double c[V], s[V];
    double diagonal = b[col];
    for (int t = 0; t < V; ++t) {
      double r;
      rotation(diagonal, v[t * vs + col], c[t], s[t], r);
      diagonal = r;
    }
    b[col] = diagonal;
    inverse[col] = 1 / diagonal;
    const auto sweep = [&](std::ptrdiff_t i) __attribute__((always_inline)) {
      Pack8 value = *reinterpret_cast<Pack8*>(b + i);
      for (int t = 0; t < V; ++t) {
        double* __restrict vt = v + t * vs + i;
        const Pack8 x = *reinterpret_cast<Pack8*>(vt);
        *reinterpret_cast<Pack8*>(vt) = c[t] * x - s[t] * value;
        value = c[t] * value + s[t] * x;
      }
      *reinterpret_cast<Pack8*>(b + i) = value;
    };
    sweep(-16);
    sweep(-8);
    const std::size_t start = (col + 1) / 8 * 8;
    if (start < m) {
      const auto below = lane >= static_cast<long long>(col + 1 - start);
      const Pack8 old = *reinterpret_cast<Pack8*>(b + start);
      Pack8 old_v[V];
      for (int t = 0; t < V; ++t) old_v[t] = *reinterpret_cast<Pack8*>(v + t * vs + start);
      sweep(static_cast<std::ptrdiff_t>(start));
      *reinterpret_cast<Pack8*>(b + start) = below ? *reinterpret_cast<Pack8*>(b + start) : old;
      for (int t = 0; t < V; ++t) {
        Pack8* at = reinterpret_cast<Pack8*>(v + t * vs + start);
        *at = below ? *at : old_v[t];
      }
    }
    for (std::size_t i = start + 8; i < m; i += 8) sweep(static_cast<std::ptrdiff_t>(i));
  }
}

FOREFEEL_INLINE double sum_of(const Pack8& p) {
  return ((p[0] + p[4]) + (p[1] + p[5])) + ((p[2] + p[6]) + (p[3] + p[7]));
}

}  // namespace

FOREFEEL_CLONES void solve_panel4(const double* l, std::size_t stride, const double* inverse_diagonal,
                                  std::size_t m, double* x) {
  solve_panel<Four>(l, stride, inverse_diagonal, m, x);
}

FOREFEEL_CLONES void solve_panel8(const double* l, std::size_t stride, const double* inverse_diagonal,
                                  std::size_t m, double* x) {
  solve_panel<Eight>(l, stride, inverse_diagonal, m, x);
}

FOREFEEL_CLONES void panel_products4(const double* x, const double* y, std::size_t stride, std::size_t m,
                                     int halves, double* gram, double* side) {
  products<Four>(x, y, stride, m, halves, gram, side);
}

FOREFEEL_CLONES void panel_products8(const double* x, const double* y, std::size_t stride, std::size_t m,
                                     int halves, double* gram, double* side) {
  products<Eight>(x, y, stride, m, halves, gram, side);
}

FOREFEEL_CLONES void rotate_columns(double* l, std::size_t stride, double* inverse_diagonal,
                                    std::size_t first, std::size_t last, std::size_t m, double* vectors,
                                    std::size_t vector_stride, int count) {
  switch (count) {
    case 1:
      return rotate_one(l, stride, inverse_diagonal, first, last, m, vectors);
    case 2:
      return rotate_many<2>(l, stride, inverse_diagonal, first, last, m, vectors, vector_stride);
    case 3:
      return rotate_many<3>(l, stride, inverse_diagonal, first, last, m, vectors, vector_stride);
    default:
      return rotate_many<4>(l, stride, inverse_diagonal, first, last, m, vectors, vector_stride);
  }
}

FOREFEEL_CLONES void solve_transposed3(const double* l, std::size_t stride, const double* inverse_diagonal,
                                       std::size_t m, double* y0, double* y1, double* y2) {
  double* __restrict y[3] = {y0, y1, y2};
  std::size_t end = m;
  if (const std::size_t odd = m % 4; odd != 0) {  // the last columns one by one, so that the rest go in fours
    for (std::size_t c = m; c-- > m - odd;)
      for (auto* yk : y) {
        double value = yk[c];
        for (std::size_t i = c + 1; i < m; ++i) value -= l[c * stride + i] * yk[i];
        yk[c] = value * inverse_diagonal[c];
      }
    end = m - odd;
  }
  for (auto* yk : y)
    for (std::size_t i = m; i < m + 8; ++i) yk[i] = 0;
  for (std::size_t c = end; c >= 4; c -= 4) {
    const std::size_t c0 = c - 4;
    const double* __restrict b0 = l + c0 * stride;
    const double* __restrict b1 = b0 + stride;
    const double* __restrict b2 = b1 + stride;
    const double* __restrict b3 = b2 + stride;
    Pack8 s0[3] = {}, s1[3] = {}, s2[3] = {}, s3[3] = {};
    const std::size_t start = c / 8 * 8;
    const auto add = [&](std::size_t i, bool whole) __attribute__((always_inline)) {
      const Pack8 l0 = *reinterpret_cast<const Pack8*>(b0 + i), l1 = *reinterpret_cast<const Pack8*>(b1 + i);
      const Pack8 l2 = *reinterpret_cast<const Pack8*>(b2 + i), l3 = *reinterpret_cast<const Pack8*>(b3 + i);
      for (int k = 0; k < 3; ++k) {
        Pack8 x = *reinterpret_cast<const Pack8*>(y[k] + i);
        if (!whole) x = lane >= static_cast<long long>(c - start) ? x : Pack8{};
        s0[k] += l0 * x;
        s1[k] += l1 * x;
        s2[k] += l2 * x;
        s3[k] += l3 * x;
      }
    };
    if (start < m) add(start, false);
    for (std::size_t i = start + 8; i < m; i += 8) add(i, true);
    for (int k = 0; k < 3; ++k) {
      double* __restrict z = y[k] + c0;
      z[3] = (z[3] - sum_of(s3[k])) * inverse_diagonal[c0 + 3];
      z[2] = (z[2] - sum_of(s2[k]) - b2[c0 + 3] * z[3]) * inverse_diagonal[c0 + 2];
      z[1] = (z[1] - sum_of(s1[k]) - b1[c0 + 2] * z[2] - b1[c0 + 3] * z[3]) * inverse_diagonal[c0 + 1];
      z[0] = (z[0] - sum_of(s0[k]) - b0[c0 + 1] * z[1] - b0[c0 + 2] * z[2] - b0[c0 + 3] * z[3]) *
             inverse_diagonal[c0];
    }
  }
}

FOREFEEL_CLONES void orthogonalise(std::size_t q, std::size_t m, double* columns, std::size_t stride,
                                   double* upper, double* right) {
  for (std::size_t j = 0; j < q + 3; ++j)
    for (std::size_t r = m; r < m + 8; ++r) columns[j * stride + r] = 0;
  const auto dot = [&](const double* __restrict a, const double* __restrict b)
      __attribute__((always_inline)) {
    Pack8 sum = {};
    for (std::size_t r = 0; r < m; r += 8)
      sum += *reinterpret_cast<const Pack8*>(a + r) * *reinterpret_cast<const Pack8*>(b + r);
    return sum_of(sum);
  };
  const auto subtract = [&](double factor, const double* __restrict a, double* __restrict b)
      __attribute__((always_inline)) {
    for (std::size_t r = 0; r < m; r += 8)
      *reinterpret_cast<Pack8*>(b + r) -= factor * *reinterpret_cast<const Pack8*>(a + r);
  };
  for (std::size_t j = 0; j < q; ++j) {
    double* unit = columns + j * stride;
    const double length = std::sqrt(dot(unit, unit));
    upper[j * q + j] = length;
    for (std::size_t r = 0; r < m; ++r) unit[r] /= length;
    for (std::size_t k = j + 1; k < q + 3; ++k) {
      double* other = columns + k * stride;
      const double along = dot(unit, other);
      subtract(along, unit, other);
      (k < q ? upper[j * q + k] : right[(k - q) * q + j]) = along;
    }
  }
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t j = 0; j < q; ++j) {
      const double along = dot(columns + j * stride, columns + (q + c) * stride);
      subtract(along, columns + j * stride, columns + (q + c) * stride);
      right[c * q + j] += along;
    }
}

FOREFEEL_CLONES void gram(std::size_t q, std::size_t m, const double* l, std::size_t stride,
                          const double* weight, double* out) {
  for (std::size_t i = 0; i < q; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      const double* __restrict a = l + i * stride;
      const double* __restrict b = l + j * stride;
      Pack8 sum = {};
      for (std::size_t r = 0; r < m; r += 8) {
        const Pack8 w = *reinterpret_cast<const Pack8*>(weight + r);
        sum += w * w * *reinterpret_cast<const Pack8*>(a + r) * *reinterpret_cast<const Pack8*>(b + r);
      }
      out[i * q + j] = sum_of(sum);
    }
}

FOREFEEL_CLONES void transpose_panel(const double* rows, std::size_t row_stride, std::size_t p, std::size_t m,
                                     double* x) {
  for (std::size_t r = 0; r < p; ++r) {
    const double* __restrict from = rows + r * row_stride;
    double* __restrict to = x + r;
    for (std::size_t c = 0; c < m; ++c) to[c * p] = from[c];
  }
}

}  // namespace forefeel::dense
