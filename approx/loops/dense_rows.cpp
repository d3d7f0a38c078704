// Compiled once per instruction set.
// Solves by rows of L and moves of rows; dense_update.cpp and dense_columns.cpp hold the other loops.
#include "approx/loops/dense_parts.hpp"

namespace forefeel::FOREFEEL_ISA {
namespace {

using dense::most_rows;
constexpr std::size_t block = 8;                           // columns that a solve takes at a time
constexpr std::size_t rows_together = width == 8 ? 4 : 2;  // rows whose factors fit into registers

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

void columns_of(const double* y, std::size_t m, std::size_t count, double* out, std::size_t stride) {
  for (std::size_t r = 0; r < m; r += width)
    for (std::size_t j = 0; j < count; j += width) {
      Pack x[width];
      for (std::size_t t = 0; t < width; ++t) x[t] = load(y + (r + t) * border + j);
      transpose(x);
      for (std::size_t t = 0; t < width && j + t < count; ++t) store(out + (j + t) * stride + r, x[t]);
    }
}

}  // namespace

extern const dense::Loops dense_loops;
const dense::Loops dense_loops = {most_together,     solve_rows, row_products,  update_columns, pick, compact,
                                  solve_transposed3, columns_of, orthogonalise, gram,           dots3};

}  // namespace forefeel::FOREFEEL_ISA
