#include "approx/dense_factor.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "approx/dense_kernels.hpp"

namespace forefeel {
namespace {
constexpr std::size_t slack = 8;  // loops run past the last row by less than a vector
}

DenseFactor::DenseFactor(std::size_t row_capacity) : row_capacity_(row_capacity) {
  if (row_capacity == 0) return;
  stride_ = (row_capacity + border + slack + 7) / 8 * 8;
  if (stride_ % 64 == 0) stride_ += 8;  // columns a power of two apart would share cache sets
  columns_.assign(stride_ * row_capacity + stride_, 0.0);
  inverse_diagonal_.assign(row_capacity + slack, 0.0);
  cross_.assign(panel * panel_stride(), 0.0);
  solved_.assign(panel * (row_capacity + slack), 0.0);
  removed_.assign(4 * stride_, 0.0);
}

void DenseFactor::remove(std::span<const std::size_t> removed) {
  for (std::size_t done = 0; done < removed.size(); done += 4) {
    const std::size_t count = std::min<std::size_t>(4, removed.size() - done);
    const auto group = removed.subspan(done, count);
    // Take the columns out as vectors; row and column become a unit row.
    for (std::size_t t = 0; t < count; ++t) {
      const std::size_t row = group[t];
      double* vector = removed_.data() + t * stride_ + border;
      double* from = column(row);
      std::copy_n(from - border, border, vector - border);
      std::fill_n(from - border, border, 0.0);
      std::copy(from + row + 1, from + rows_, vector + row + 1);
      std::fill_n(vector + rows_, slack, 0.0);
      std::fill(from + row + 1, from + rows_, 0.0);
      from[row] = 1;
      inverse_diagonal_[row] = 1;
      for (std::size_t c = 0; c < row; ++c) column(c)[row] = 0;
      for (std::size_t s = 0; s < t; ++s) removed_[s * stride_ + border + row] = 0;
    }
    for (std::size_t t = 0; t < count; ++t) {
      const std::size_t last = t + 1 < count ? group[t + 1] : rows_;
      dense::rotate_columns(column(0), stride_, inverse_diagonal_.data(), group[t] + 1, last, rows_,
                            removed_.data() + border, stride_, static_cast<int>(t + 1));
    }
  }
}

std::uint32_t DenseFactor::append(std::size_t count, std::size_t used, std::uint32_t skip,
                                  const double* tolerance, std::size_t used_border) {
  assert(count == 4 || count == panel);
  assert(rows_ + count <= row_capacity_);
  const std::size_t m = rows_;
  const int halves = used_border > 8 ? 2 : 1;
  double gram[panel * panel], side[panel * border] = {};
  double* x = solved_.data();
  dense::transpose_panel(cross_.data(), panel_stride(), count, m, x);
  if (count == panel) {
    dense::solve_panel8(column(0), stride_, inverse_diagonal_.data(), m, x);
    dense::panel_products8(x, columns_.data(), stride_, m, halves, gram, side);
  } else {
    dense::solve_panel4(column(0), stride_, inverse_diagonal_.data(), m, x);
    dense::panel_products4(x, columns_.data(), stride_, m, halves, gram, side);
  }

  // The small factor of what the old rows leave unexplained, row by row; a row that adds nothing is dropped.
  std::uint32_t taken = 0;
  double small[panel][panel] = {};
  for (std::size_t r = 0; r < count; ++r) {
    double* y = columns_.data() + (m + r) * stride_;
    std::fill_n(y, stride_, 0.0);
    const double* diagonal = panel_row(r) + m;
    double pivot = diagonal[r] - gram[r * count + r];
    if ((skip >> r & 1u) == 0) {
      for (std::size_t c = 0; c < r; ++c) {
        if ((taken >> c & 1u) == 0) continue;
        double value = diagonal[c] - gram[r * count + c];
        for (std::size_t k = 0; k < c; ++k) value -= small[r][k] * small[c][k];
        small[r][c] = value / small[c][c];
        pivot -= small[r][c] * small[r][c];
      }
    }
    if ((skip >> r & 1u) != 0 || !(pivot > tolerance[r] * diagonal[r])) {
      std::fill_n(small[r], panel, 0.0);
      small[r][r] = 1;
      for (std::size_t c = 0; c < m; ++c) x[c * count + r] = 0;
      continue;
    }
    taken |= 1u << r;
    small[r][r] = std::sqrt(pivot);
    const double* b = panel_border(r);
    for (std::size_t t = 0; t < border; ++t) {
      double value = b[t] - side[r * border + t];
      for (std::size_t c = 0; c < r; ++c) value -= small[r][c] * columns_[(m + c) * stride_ + t];
      y[t] = value / small[r][r];
    }
  }
  for (std::size_t c = 0; c < m; ++c) std::copy_n(x + c * count, count, column(c) + m);
  for (std::size_t c = 0; c < count; ++c) {
    for (std::size_t r = c; r < count; ++r) column(m + c)[m + r] = small[r][c];
    inverse_diagonal_[m + c] = 1 / small[c][c];
  }
  rows_ += used;
  return taken;
}

void DenseFactor::compact(std::span<const std::size_t> kept) {
  for (std::size_t c = 0; c < kept.size(); ++c) {
    const double* from = columns_.data() + kept[c] * stride_;
    double* to = columns_.data() + c * stride_;
    if (to != from) std::copy_n(from, border, to);
    for (std::size_t r = c; r < kept.size(); ++r) to[border + r] = from[border + kept[r]];
    inverse_diagonal_[c] = inverse_diagonal_[kept[c]];
  }
  rows_ = kept.size();
}

void DenseFactor::solve_transposed(double* y0, double* y1, double* y2) const {
  dense::solve_transposed3(column(0), stride_, inverse_diagonal_.data(), rows_, y0, y1, y2);
}

}  // namespace forefeel
