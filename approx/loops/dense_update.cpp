// Positive update L L^T + V V^T by reflections, one a column. Compiled once per instruction set.
#include "approx/loops/dense_parts.hpp"

namespace forefeel::FOREFEEL_ISA {
namespace {

// The reflection I - k u u^T, u = (-s, v), that takes (d, v) to (r, 0): with t = |v|^2
//   s = t / (d + r),   k = (d + r) / (r t),   so that k s = 1 / r.
// Nothing cancels, and as v tends to 0 the reflection tends to one that leaves d as it is. The three
// divisions do not depend on each other.
template <std::size_t G>
struct Reflection {
  double s, k, inverse, v[G];
};

template <std::size_t G>
FOREFEEL_INLINE double reflection(double d, const double* v, std::size_t stride, Reflection<G>& h) {
  double part[4] = {};
#pragma GCC unroll 20
  for (std::size_t g = 0; g < G; ++g) {
    h.v[g] = v[g * stride];
    part[g % 4] += h.v[g] * h.v[g];
  }
  const double t = (part[0] + part[1]) + (part[2] + part[3]);
  if (!(t > 1e-290)) {
    h = {};
    h.inverse = 1 / d;
    return d;
  }
  const double r = __builtin_sqrt(d * d + t), sum = d + r;
  h.inverse = 1 / r;
  h.s = t / sum;
  h.k = sum / (r * t);
  return r;
}

template <std::size_t G, class Value>
FOREFEEL_INLINE void reflect(const Reflection<G>& h, Value& l, Value (&v)[G]) {
  constexpr std::size_t chains = G > 8 ? 4 : 2;
  Value part[chains] = {h.v[0] * v[0], -h.s * l};
  if constexpr (chains == 4) {
    part[2] = h.v[2] * v[2];
    part[3] = h.v[3] * v[3];
    part[1] += h.v[1] * v[1];
  }
#pragma GCC unroll 20
  for (std::size_t g = chains == 4 ? 4 : 1; g < G; ++g) part[g % chains] += h.v[g] * v[g];
  Value w = part[0] + part[1];
  if constexpr (chains == 4) w += part[2] + part[3];
  const Value step = h.k * w;
  l += h.inverse * w;
#pragma GCC unroll 20
  for (std::size_t g = 0; g < G; ++g) v[g] -= h.v[g] * step;
}

// The reflections of C columns, and the diagonal block after them.
template <std::size_t G, std::size_t C>
struct Corner {
  Reflection<G> h[C];
  double l[C][C];  // by column, from its diagonal on
};

template <std::size_t G, std::size_t C>
FOREFEEL_INLINE void make_corner(const double* __restrict l, std::size_t stride, std::size_t col,
                                 const double* __restrict v, std::size_t vs, Corner<G, C>& __restrict out) {
  double x[C][G];
#pragma GCC unroll 20
  for (std::size_t g = 0; g < G; ++g)
#pragma GCC unroll 4
    for (std::size_t i = 0; i < C; ++i) x[i][g] = v[g * vs + col + i];
#pragma GCC unroll 4
  for (std::size_t t = 0; t < C; ++t) {
    const double* __restrict column = l + (col + t) * stride + col + t;
    out.l[t][0] = reflection<G>(column[0], x[t], 1, out.h[t]);
#pragma GCC unroll 4
    for (std::size_t i = t + 1; i < C; ++i) {
      double value = column[i - t];
      reflect<G>(out.h[t], value, x[i]);
      out.l[t][i - t] = value;
    }
  }
}

// Reflects one vector of rows of C columns (at at[t]) and of G update vectors, which are read and written
// once for all columns. Of the columns only the lanes from `skip` on are written.
template <std::size_t G, std::size_t C>
FOREFEEL_INLINE void reflect_rows(const Reflection<G>* __restrict h, double* const* at, double* from,
                                  std::size_t from_stride, std::size_t skip = 0) {
  Pack x[G];
#pragma GCC unroll 20
  for (std::size_t g = 0; g < G; ++g) x[g] = load(from + g * from_stride);
  for (std::size_t t = 0; t < C; ++t) {
    Pack value = load(at[t]);
    reflect<G>(h[t], value, x);
    if (skip == 0)
      store(at[t], value);
    else
      store_from(at[t], value, skip);
  }
#pragma GCC unroll 20
  for (std::size_t g = 0; g < G; ++g) store(from + g * from_stride, x[g]);
}

// The columns col to col + C - 1 of L and Y.
template <std::size_t G, std::size_t C>
struct Columns {
  double *l, *y, *v, *side;
  std::size_t stride, vs, m, col;

  FOREFEEL_INLINE void rows(const Corner<G, C>& corner, std::size_t i, std::size_t skip = 0) const {
    double* at[C];
    for (std::size_t t = 0; t < C; ++t) at[t] = l + (col + t) * stride + i;
    reflect_rows<G, C>(corner.h, at, v + i, vs, skip);
  }
  // Reflects the vector that holds the first row below the corner, then stores the corner. The order matters:
  // reading a vector right after storing single entries of it would stall. Returns the next row.
  FOREFEEL_INLINE std::size_t begin(const Corner<G, C>& corner, double* inverse) const {
    const std::size_t next = col + C, i = next / width * width;
    if (i < next && i < m) rows(corner, i, next - i);
    for (std::size_t t = 0; t < C; ++t) {
      for (std::size_t r = t; r < C; ++r) l[(col + t) * stride + col + r] = corner.l[t][r - t];
      inverse[col + t] = corner.h[t].inverse;
    }
    return i < next ? i + width : next;
  }
  FOREFEEL_INLINE void end(const Corner<G, C>& corner, std::size_t i) const {
    for (; i < m; i += width) rows(corner, i);
    double* at[C];
    for (std::size_t j = 0; j < border; j += width) {
      for (std::size_t t = 0; t < C; ++t) at[t] = y + (col + t) * border + j;
      reflect_rows<G, C>(corner.h, at, side + j, border);
    }
  }
};

// The columns first <= c < last, C at a time. With many vectors, the reflections of the next columns are
// computed as soon as their rows are ready, so that their roots and divisions overlap with the reflection of
// the other rows.
template <std::size_t G, std::size_t C>
FOREFEEL_INLINE std::size_t update_by(double* __restrict l, std::size_t stride, double* __restrict inverse,
                                      double* __restrict y, std::size_t first, std::size_t last,
                                      std::size_t m, double* __restrict v, std::size_t vs,
                                      double* __restrict side) {
  Columns<G, C> columns{l, y, v, side, stride, vs, m, first};
  if constexpr (G <= 8) {
    for (; columns.col + C <= last; columns.col += C) {
      Corner<G, C> corner;
      make_corner<G, C>(l, stride, columns.col, v, vs, corner);
      columns.end(corner, columns.begin(corner, inverse));
    }
  } else {
    Corner<G, C> corners[2];
    if (first + C <= last) make_corner<G, C>(l, stride, first, v, vs, corners[0]);
    for (int turn = 0; columns.col + C <= last; turn ^= 1, columns.col += C) {
      const std::size_t next = columns.col + C;
      std::size_t i = columns.begin(corners[turn], inverse);
      if (next + C <= last) {
        for (; i < next + C; i += width) columns.rows(corners[turn], i);
        make_corner<G, C>(l, stride, next, v, vs, corners[turn ^ 1]);
      }
      columns.end(corners[turn], i);
    }
  }
  return columns.col;
}

template <std::size_t G>
FOREFEEL_INLINE void update_by(double* l, std::size_t stride, double* inverse, double* y, std::size_t first,
                               std::size_t last, std::size_t m, double* v, std::size_t vs, double* side) {
  constexpr std::size_t C = G <= 4 ? 4 : 2;
  first = update_by<G, C>(l, stride, inverse, y, first, last, m, v, vs, side);
  update_by<G, 1>(l, stride, inverse, y, first, last, m, v, vs, side);
}

}  // namespace

void update_columns(double* l, std::size_t stride, double* inverse, double* y, std::size_t first,
                    std::size_t last, std::size_t m, double* v, std::size_t vs, double* side,
                    std::size_t count) {
  if constexpr (most_together > 8) {
    if (count > 16) return update_by<20>(l, stride, inverse, y, first, last, m, v, vs, side);
    if (count > 12) return update_by<16>(l, stride, inverse, y, first, last, m, v, vs, side);
    if (count > 8) return update_by<12>(l, stride, inverse, y, first, last, m, v, vs, side);
  }
  with_count<1, 8>(
      count, [&](auto together) __attribute__((always_inline)) {
        update_by<together>(l, stride, inverse, y, first, last, m, v, vs, side);
      });
}

}  // namespace forefeel::FOREFEEL_ISA
