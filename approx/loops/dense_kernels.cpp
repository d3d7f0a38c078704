// Compiled once per instruction set.
#include "approx/loops/dense_kernels.hpp"

#include <type_traits>

#include "approx/loops/lanes.hpp"

namespace forefeel::FOREFEEL_ISA {
namespace {

using dense::border;
using dense::most_rows;
constexpr std::size_t block = 8;                            // columns that a solve takes at a time
constexpr std::size_t most_together = width == 8 ? 20 : 8;  // vectors of an update that fit into registers
constexpr std::size_t rows_together = width == 8 ? 4 : 2;   // rows whose factors fit into registers

// action(n) with n, Least <= n <= Most, known when this is compiled.
template <std::size_t Least, std::size_t Most, class Action>
FOREFEEL_INLINE void with_count(std::size_t n, const Action& action) {
  if constexpr (Least < Most)
    if (n != Least) return with_count<Least + 1, Most>(n, action);
  action(std::integral_constant<std::size_t, Least>{});
}

// S -= factors times rows of length `count` (a multiple of the width) at from[t * stride], t < C.
template <std::size_t P, std::size_t C>
FOREFEEL_INLINE void subtract(const double* __restrict from, std::size_t stride, std::size_t begin,
                              std::size_t end, const double* __restrict factor, double* rows,
                              std::size_t row_stride) {
  Pack f[P][C];
  for (std::size_t p = 0; p < P; ++p)
    for (std::size_t t = 0; t < C; ++t) f[p][t] = same(factor[p * block + t]);
  for (std::size_t i = begin; i < end; i += width) {
    Pack l[C];
    for (std::size_t t = 0; t < C; ++t) l[t] = load(from + t * stride + i);
    for (std::size_t p = 0; p < P; ++p) {
      Pack x = load(rows + p * row_stride + i);
      Pack second = f[p][C / 2] * l[C / 2];  // a second chain halves the delay
      for (std::size_t t = 0; t < C / 2; ++t) x -= f[p][t] * l[t];
      for (std::size_t t = C / 2 + 1; t < C; ++t) second += f[p][t] * l[t];
      store(rows + p * row_stride + i, x - second);
    }
  }
}

// x := x L_cc^-T for the diagonal block of the columns c to c + 7: one row, or as many as a vector has lanes.
FOREFEEL_INLINE void solve_diagonal(const double* __restrict l, std::size_t stride,
                                    const double* __restrict inverse, double* __restrict x) {
  for (std::size_t t = 0; t < block; ++t) {
    double value = x[t];
    for (std::size_t s = 0; s < t; ++s) value -= x[s] * l[s * stride + t];
    x[t] = value * inverse[t];
  }
}

FOREFEEL_INLINE void solve_diagonal(const double* __restrict l, std::size_t stride,
                                    const double* __restrict inverse, double* rows, std::size_t row_stride,
                                    std::size_t count) {
  Pack x[block];  // by column
  for (std::size_t part = 0; part < block; part += width) {
    for (std::size_t r = 0; r < width; ++r)
      x[part + r] = r < count ? load(rows + r * row_stride + part) : Pack{};
    transpose(x + part);
  }
  for (std::size_t t = 0; t < block; ++t) {
    x[t] *= inverse[t];
    for (std::size_t s = t + 1; s < block; ++s) x[s] -= x[t] * l[t * stride + s];
  }
  for (std::size_t part = 0; part < block; part += width) {
    transpose(x + part);
    for (std::size_t r = 0; r < width && r < count; ++r) store(rows + r * row_stride + part, x[part + r]);
  }
}

// P rows, solved up to column c + 7, leave the rows after it and the border.
template <std::size_t P>
FOREFEEL_INLINE void subtract_block(const double* __restrict l, std::size_t stride,
                                    const double* __restrict y, std::size_t m, std::size_t c, double* rows,
                                    std::size_t row_stride, double* side) {
  double factor[P * block];
  for (std::size_t p = 0; p < P; ++p)
    for (std::size_t t = 0; t < block; ++t) factor[p * block + t] = rows[p * row_stride + c + t];
  const double* from = l + c * stride;
  if constexpr (P <= rows_together / 2) {
    subtract<P, 8>(from, stride, c + block, m, factor, rows, row_stride);
    subtract<P, 8>(y + c * border, border, 0, border, factor, side, border);
  } else {
    subtract<P, 4>(from, stride, c + block, m, factor, rows, row_stride);
    subtract<P, 4>(from + 4 * stride, stride, c + block, m, factor + 4, rows, row_stride);
    subtract<P, 4>(y + c * border, border, 0, border, factor, side, border);
    subtract<P, 4>(y + (c + 4) * border, border, 0, border, factor + 4, side, border);
  }
}

// The last columns, fewer than a block.
FOREFEEL_INLINE void solve_end(const double* l, std::size_t stride, const double* inverse, const double* y,
                               std::size_t c, std::size_t m, double* __restrict row,
                               double* __restrict side) {
  for (std::size_t t = c; t < m; ++t) {
    double value = row[t];
    for (std::size_t s = c; s < t; ++s) value -= row[s] * l[s * stride + t];
    row[t] = value * inverse[t];
    for (std::size_t j = 0; j < border; j += width)
      store(side + j, load(side + j) - row[t] * load(y + t * border + j));
  }
}

void solve_rows(const double* l, std::size_t stride, const double* inverse, const double* y, std::size_t m,
                double* rows, std::size_t row_stride, double* side, std::size_t count) {
  std::size_t c = 0;
  for (; c + block <= m; c += block) {
    const double* corner = l + c * stride + c;
    if (count < 3)
      for (std::size_t r = 0; r < count; ++r)
        solve_diagonal(corner, stride, inverse + c, rows + r * row_stride + c);
    else
      for (std::size_t r = 0; r < count; r += width)
        solve_diagonal(corner, stride, inverse + c, rows + r * row_stride + c, row_stride, count - r);
    for (std::size_t r = 0; r < count; r += rows_together) {
      double* x = rows + r * row_stride;
      double* s = side + r * border;
      const std::size_t some = count - r < rows_together ? count - r : rows_together;
      with_count<1, 4>(
          some, [&](auto rows_of) __attribute__((always_inline)) {
            subtract_block<rows_of>(l, stride, y, m, c, x, row_stride, s);
          });
    }
  }
  for (std::size_t r = 0; r < count; ++r)
    solve_end(l, stride, inverse, y, c, m, rows + r * row_stride, side + r * border);
}

void row_products(double* rows, std::size_t row_stride, std::size_t m, std::size_t count, double* gram) {
  for (std::size_t r = 0; r < count; ++r) {
    double* __restrict x = rows + r * row_stride;
    for (std::size_t i = m; i < m + 8; ++i) x[i] = 0;
  }
  for (std::size_t r = 0; r < count; ++r)
    for (std::size_t c = 0; c <= r; c += 4) {  // four at a time; those beyond r are not asked for
      const double* x = rows + r * row_stride;
      const double* a[4];
      for (std::size_t t = 0; t < 4; ++t) a[t] = rows + (c + t <= r ? c + t : c) * row_stride;
      Pack sum[4] = {};
      for (std::size_t i = 0; i < m; i += width) {
        const Pack value = load(x + i);
        for (std::size_t t = 0; t < 4; ++t) sum[t] += value * load(a[t] + i);
      }
      for (std::size_t t = 0; t < 4 && c + t <= r; ++t) gram[most_rows * r + c + t] = sum_of(sum[t]);
    }
}

// The reflection I - k u u^T, u = (-s, v), that takes (d, v) to (r, 0): with t = |v|^2
//   s = t / (d + r),   k = (d + r) / (r t),   so that k s = 1 / r.
// Nothing cancels, and it tends to one that leaves d alone as v vanishes. The three divisions do not wait for
// each other.
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

// The reflections of C columns and what they make of their diagonal block.
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

// A vector of rows of C columns at at[t] and of G vectors, which are read and written once for all of them; of
// the columns only the lanes from `skip` on.
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

  inline __attribute__((always_inline)) void rows(const Corner<G, C>& corner, std::size_t i,
                                                  std::size_t skip = 0) const {
    double* at[C];
    for (std::size_t t = 0; t < C; ++t) at[t] = l + (col + t) * stride + i;
    reflect_rows<G, C>(corner.h, at, v + i, vs, skip);
  }
  // The vector that holds the first row below the corner, then the corner: what is stored one by one is stored
  // after the vector around it has been read, which would have to wait for it. Returns the next row.
  inline __attribute__((always_inline)) std::size_t begin(const Corner<G, C>& corner, double* inverse) const {
    const std::size_t next = col + C, i = next / width * width;
    if (i < next && i < m) rows(corner, i, next - i);
    for (std::size_t t = 0; t < C; ++t) {
      for (std::size_t r = t; r < C; ++r) l[(col + t) * stride + col + r] = corner.l[t][r - t];
      inverse[col + t] = corner.h[t].inverse;
    }
    return i < next ? i + width : next;
  }
  inline __attribute__((always_inline)) void end(const Corner<G, C>& corner, std::size_t i) const {
    for (; i < m; i += width) rows(corner, i);
    double* at[C];
    for (std::size_t j = 0; j < border; j += width) {
      for (std::size_t t = 0; t < C; ++t) at[t] = y + (col + t) * border + j;
      reflect_rows<G, C>(corner.h, at, side + j, border);
    }
  }
};

// The columns first <= c < last, C at a time. With many vectors the reflections of the next columns are made as
// soon as their rows are there: their roots and divisions take their time while the rest of the rows is reflected.
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

// Rows from `begin` on of one column.
FOREFEEL_INLINE void move_rows(const double* from, double* to, const dense::Kept& kept, std::size_t begin) {
  if (kept.fours != nullptr) {  // no branch that depends on which rows they are
    for (std::size_t i = begin / 4; 4 * i < kept.size; ++i) move_four(to + 4 * i, from + kept.fours[i]);
    return;
  }
  const dense::Run* runs = kept.runs;
  for (std::size_t k = 0; k + 1 < kept.run_count; ++k) {
    if (from == to && runs[k].from == runs[k].to) continue;
    std::size_t r = begin > runs[k].to ? begin : runs[k].to;
    const std::size_t end = runs[k + 1].to;
    const double* source = from + (runs[k].from - runs[k].to);
    for (; r + width <= end; r += width) store(to + r, load(source + r));
    for (; r < end; ++r) to[r] = source[r];
  }
}

void pick(const double* column, const dense::Kept& kept, std::size_t begin, double* to) {
  move_rows(column, to, kept, begin);
  for (std::size_t i = 0; i < begin; ++i) to[i] = 0;
}

void compact(double* l, std::size_t stride, const dense::Kept& kept) {
  for (std::size_t run = 0; run + 1 < kept.run_count; ++run)
    for (std::size_t c = kept.runs[run].to; c < kept.runs[run + 1].to; ++c)
      move_rows(l + (kept.runs[run].from + c - kept.runs[run].to) * stride, l + c * stride, kept, c);
}

void solve_transposed3(const double* l, std::size_t stride, const double* inverse, std::size_t m, double* y0,
                       double* y1, double* y2) {
  double* __restrict y[3] = {y0, y1, y2};
  std::size_t end = m;
  if (const std::size_t odd = m % 4; odd != 0) {  // the last columns one by one, so that the rest go in fours
    for (std::size_t c = m; c-- > m - odd;)
      for (auto* yk : y) {
        double value = yk[c];
        for (std::size_t i = c + 1; i < m; ++i) value -= l[c * stride + i] * yk[i];
        yk[c] = value * inverse[c];
      }
    end = m - odd;
  }
  for (auto* yk : y)
    for (std::size_t i = m; i < m + 8; ++i) yk[i] = 0;
  for (std::size_t c = end; c >= 4; c -= 4) {
    const std::size_t c0 = c - 4;
    const double* __restrict b = l + c0 * stride;
    Pack sum[3][4] = {};
    const auto add = [&](std::size_t i, Pack x0, Pack x1, Pack x2) __attribute__((always_inline)) {
      for (std::size_t t = 0; t < 4; ++t) {
        const Pack value = load(b + t * stride + i);
        sum[0][t] += value * x0;
        sum[1][t] += value * x1;
        sum[2][t] += value * x2;
      }
    };
    // The four just solved come last, so that the others need not wait for them, and by a load that asks for
    // no more than their store.
    const std::size_t whole = width == 8 ? (c + 11) / 8 * 8 : c + 4;
    for (std::size_t i = whole; i < m; i += width) add(i, load(y[0] + i), load(y[1] + i), load(y[2] + i));
    for (std::size_t i = whole; i > c;) {
      i -= 4;
      if (i < m)
        for (std::size_t part = i; part < i + 4; part += width)
          add(part, load_four(y[0] + part), load_four(y[1] + part), load_four(y[2] + part));
    }
    const double* __restrict b1 = b + stride;
    const double* __restrict b2 = b1 + stride;
    for (std::size_t k = 0; k < 3; ++k) {
      double s[4];
      sums_of(sum[k], s);
      double* __restrict z = y[k] + c0;
      const double z3 = (z[3] - s[3]) * inverse[c0 + 3];
      const double z2 = (z[2] - s[2] - b2[c0 + 3] * z3) * inverse[c0 + 2];
      const double z1 = (z[1] - s[1] - b1[c0 + 3] * z3 - b1[c0 + 2] * z2) * inverse[c0 + 1];
      const double z0 = (z[0] - s[0] - b[c0 + 3] * z3 - b[c0 + 2] * z2 - b[c0 + 1] * z1) * inverse[c0];
      store_four(z, z0, z1, z2, z3);
    }
  }
}

void columns_of(const double* y, std::size_t m, std::size_t count, double* out, std::size_t stride) {
  for (std::size_t r = 0; r < m; r += width)
    for (std::size_t j = 0; j < count; j += width) {
      Pack x[width];
      for (std::size_t t = 0; t < width; ++t) x[t] = load(y + (r + t) * border + j);
      transpose(x);
      for (std::size_t t = 0; t < width && j + t < count; ++t) store(out + (j + t) * stride + r, x[t]);
    }
}

// One step of modified Gram-Schmidt on a column c and the K after it, whose products with it (its own square
// first) stand in `products`: takes it out of the others, normalises it, and leaves the products of the next
// column with those after it. One sweep for all of them.
template <std::size_t K>
FOREFEEL_INLINE void take_out(std::size_t m, double* __restrict c, std::size_t stride, double* products) {
  const double unit = 1 / __builtin_sqrt(products[0]), squared = 1 / products[0];
  Pack share[K], sum[K] = {};
  for (std::size_t t = 0; t < K; ++t) share[t] = same(products[t + 1] * squared);
  for (std::size_t r = 0; r < m; r += width) {
    const Pack x = load(c + r), next = load(c + stride + r) - share[0] * x;
    store(c + r, x * unit);
    store(c + stride + r, next);
    sum[0] += next * next;
    for (std::size_t t = 1; t < K; ++t) {
      const Pack other = load(c + (t + 1) * stride + r) - share[t] * x;
      store(c + (t + 1) * stride + r, other);
      sum[t] += next * other;
    }
  }
  constexpr std::size_t whole = K / 4 * 4;
  for (std::size_t t = 0; t < whole; t += 4) sums_of(sum + t, products + t);
  for (std::size_t t = whole; t < K; ++t) products[t] = sum_of(sum[t]);
}

// Takes Q orthonormal columns out of three more once again; their components are added to right[c * q + j].
template <std::size_t Q>
FOREFEEL_INLINE void take_out_again(std::size_t q, std::size_t m, const double* __restrict columns,
                                    std::size_t stride, double* __restrict rest, double* right) {
  Pack sum[3][Q] = {};
  for (std::size_t r = 0; r < m; r += width) {
    const Pack x[3] = {load(rest + r), load(rest + stride + r), load(rest + 2 * stride + r)};
    for (std::size_t j = 0; j < Q; ++j) {
      const Pack unit = load(columns + j * stride + r);
      for (std::size_t c = 0; c < 3; ++c) sum[c][j] += unit * x[c];
    }
  }
  double along[3][Q];
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t j = 0; j < Q; ++j) right[c * q + j] += along[c][j] = sum_of(sum[c][j]);
  for (std::size_t r = 0; r < m; r += width)
    for (std::size_t c = 0; c < 3; ++c) {
      Pack x = load(rest + c * stride + r);
      for (std::size_t j = 0; j < Q; ++j) x -= along[c][j] * load(columns + j * stride + r);
      store(rest + c * stride + r, x);
    }
}

void orthogonalise(std::size_t q, std::size_t m, double* columns, std::size_t stride, double* upper,
                   double* right) {
  const std::size_t all = q + 3;
  for (std::size_t j = 0; j < all + 1; ++j)
    for (std::size_t r = m; r < m + 8; ++r) columns[j * stride + r] = 0;
  double products[16];
  for (std::size_t k = 0; k < all; ++k) {
    Pack sum = {};
    for (std::size_t r = 0; r < m; r += width) sum += load(columns + r) * load(columns + k * stride + r);
    products[k] = sum_of(sum);
  }
  for (std::size_t j = 0; j < q; ++j) {
    const double length = __builtin_sqrt(products[0]);
    upper[j * q + j] = length;
    for (std::size_t k = j + 1; k < all; ++k)
      (k < q ? upper[j * q + k] : right[(k - q) * q + j]) = products[k - j] / length;
    double* c = columns + j * stride;
    with_count<3, 12>(
        all - j - 1, [&](auto after)
                         __attribute__((always_inline)) { take_out<after>(m, c, stride, products); });
  }
  double* rest = columns + q * stride;
  if (q == 10) {
    take_out_again<5>(q, m, columns, stride, rest, right);
    take_out_again<5>(q, m, columns + 5 * stride, stride, rest, right + 5);
  } else if (q == 4) {
    take_out_again<4>(q, m, columns, stride, rest, right);
  } else {
    take_out_again<1>(q, m, columns, stride, rest, right);
  }
}

// Rows i and i + 1 of the products with all columns before them, four columns at a time.
void gram(std::size_t q, std::size_t m, const double* l, std::size_t stride, const double* weight,
          double* out) {
  for (std::size_t i = 0; i < q; i += 2) {
    const double* a[2] = {l + i * stride, l + (i + 1 < q ? i + 1 : i) * stride};
    for (std::size_t j = 0; j < q && j < i + 2; j += 4) {
      const double* b[4];
      for (std::size_t t = 0; t < 4; ++t) b[t] = l + (j + t < q ? j + t : j) * stride;
      Pack sum[2][4] = {};
      for (std::size_t r = 0; r < m; r += width) {
        const Pack w = load(weight + r), w2 = w * w;
        const Pack x[2] = {w2 * load(a[0] + r), w2 * load(a[1] + r)};
        for (std::size_t t = 0; t < 4; ++t) {
          const Pack y = load(b[t] + r);
          for (std::size_t s = 0; s < 2; ++s) sum[s][t] += x[s] * y;
        }
      }
      for (std::size_t s = 0; s < 2; ++s) {
        double four[4];
        sums_of(sum[s], four);
        for (std::size_t t = 0; t < 4 && i + s < q && j + t <= i + s; ++t) out[(i + s) * q + j + t] = four[t];
      }
    }
  }
}

void dots3(std::size_t q, std::size_t m, const double* a, const double* v, std::size_t stride, double* out) {
  for (std::size_t j = 0; j < q; ++j) {
    Pack sum[3] = {};
    for (std::size_t r = 0; r < m; r += width) {
      const Pack x = load(v + j * stride + r);
      for (std::size_t c = 0; c < 3; ++c) sum[c] += x * load(a + c * stride + r);
    }
    for (std::size_t c = 0; c < 3; ++c) out[c * q + j] = sum_of(sum[c]);
  }
}

}  // namespace

extern const dense::Loops dense_loops;
const dense::Loops dense_loops = {most_together,     solve_rows, row_products,  update_columns, pick, compact,
                                  solve_transposed3, columns_of, orthogonalise, gram,           dots3};

}  // namespace forefeel::FOREFEEL_ISA
