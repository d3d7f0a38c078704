#include "approx/model/dense_factor.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace forefeel {
namespace {
constexpr std::size_t slack = 8;  // loops run past the last row by less than a vector
}

DenseFactor::DenseFactor(std::size_t row_capacity) : row_capacity_(row_capacity) {
  if (row_capacity == 0) return;
  stride_ = (row_capacity + slack + 7) / 8 * 8;
  if (stride_ % 64 == 0) stride_ += 8;  // else columns would lie a power of two apart and share cache sets
  columns_.assign(stride_ * row_capacity, 0.0);
  border_.assign(border * (row_capacity + slack), 0.0);
  inverse_diagonal_.assign(row_capacity + slack, 0.0);
  new_rows_.rows.assign(panel * panel_stride(), 0.0);
  new_rows_.border.assign(panel * border, 0.0);
  vectors_.rows.assign(most_vectors * stride_, 0.0);
  vectors_.border.assign(most_vectors * border, 0.0);
  starts_.reserve(most_vectors);
  runs_.reserve(row_capacity + 1);
  fours_.reserve(row_capacity / 4 + 1);
}

void DenseFactor::remove(std::span<const std::size_t> removed) {
  for (std::size_t done = 0; done < removed.size(); done += most_vectors) {
    take_out(removed.subspan(done, std::min(most_vectors, removed.size() - done)));
    update();
  }
}

void DenseFactor::remove(std::span<const std::size_t> removed, std::span<const std::size_t> kept) {
  const std::size_t last = std::min(most_vectors, removed.size());
  remove(removed.first(removed.size() - last));
  close_up(removed.last(last), kept);
  update();
}

// The deleted columns become vectors of an update; each deleted row becomes a unit row.
void DenseFactor::take_out(std::span<const std::size_t> removed) {
  starts_.clear();
  for (std::size_t t = 0; t < removed.size(); ++t) {
    const std::size_t row = removed[t];
    double* vector = vectors_.rows.data() + t * stride_;
    double* from = column(row);
    std::copy_n(border_.data() + row * border, border, vectors_.border.data() + t * border);
    std::fill_n(border_.data() + row * border, border, 0.0);
    std::fill_n(vector, row + 1, 0.0);
    std::copy(from + row + 1, from + rows_, vector + row + 1);
    std::fill_n(vector + rows_, slack, 0.0);
    std::fill(from + row + 1, from + rows_, 0.0);
    from[row] = 1;
    inverse_diagonal_[row] = 1;
    for (std::size_t c = 0; c < row; ++c) column(c)[row] = 0;
    for (std::size_t s = 0; s < t; ++s) vectors_.rows[s * stride_ + row] = 0;
    starts_.push_back(row + 1);
  }
}

// The deleted columns become vectors of an update; the kept rows close up.
void DenseFactor::close_up(std::span<const std::size_t> removed, std::span<const std::size_t> kept) {
  const dense::Loops& loops = dense::loops();
  const dense::Kept stay = describe(kept);
  starts_.clear();
  std::size_t start = 0;  // kept rows before the one that is taken out
  for (std::size_t t = 0; t < removed.size(); ++t) {
    while (start < kept.size() && kept[start] < removed[t]) ++start;
    double* vector = vectors_.rows.data() + t * stride_;
    loops.pick(column(removed[t]), stay, start, vector);
    std::fill_n(vector + kept.size(), slack, 0.0);
    std::copy_n(border_row(removed[t]), border, vectors_.border.data() + t * border);
    starts_.push_back(start);
  }
  loops.compact(column(0), stride_, stay);
  for (std::size_t k = 0; k + 1 < runs_.size(); ++k) {
    const std::size_t to = runs_[k].to, from = runs_[k].from, count = runs_[k + 1].to - to;
    if (to == from) continue;
    std::copy_n(border_row(from), count * border, border_.data() + to * border);
    std::copy_n(inverse_diagonal_.data() + from, count, inverse_diagonal_.data() + to);
  }
  rows_ = kept.size();
}

dense::Kept DenseFactor::describe(std::span<const std::size_t> kept) {
  runs_.clear();
  fours_.clear();
  bool in_fours = kept.size() % 4 == 0;
  for (std::size_t r = 0; r < kept.size(); ++r) {
    const bool next = r > 0 && kept[r] == kept[r - 1] + 1;
    if (!next) runs_.push_back({r, kept[r]});
    if (r % 4 == 0)
      fours_.push_back(kept[r]);
    else
      in_fours = in_fours && next;
  }
  runs_.push_back({kept.size(), 0});
  return {kept.size(), runs_.data(), runs_.size(), in_fours ? fours_.data() : nullptr};
}

// The columns from a vector's start on change with it.
void DenseFactor::update() {
  const dense::Loops& loops = dense::loops();
  const std::size_t all = starts_.size(), together = rows_ <= 128 ? loops.most_together : std::size_t{8};
  for (std::size_t t = all; all > 8 && t % 4 != 0; ++t) {
    std::fill_n(vectors_.rows.data() + t * stride_, rows_ + slack, 0.0);
    std::fill_n(vectors_.border.data() + t * border, border, 0.0);
  }
  for (std::size_t done = 0; done < all; done += together) {
    const std::size_t end = std::min(all, done + together);
    for (std::size_t t = done; t < end; ++t) {
      const std::size_t last = t + 1 < end ? starts_[t + 1] : rows_;
      if (starts_[t] < last)
        loops.update_columns(column(0), stride_, inverse_diagonal_.data(), border_.data(), starts_[t], last,
                             rows_, vectors_.rows.data() + done * stride_, stride_,
                             vectors_.border.data() + done * border, t + 1 - done);
    }
  }
}

std::uint32_t DenseFactor::append(std::size_t count, std::uint32_t skip, const double* tolerance) {
  assert(count <= panel && rows_ + count <= row_capacity_);
  const dense::Loops& loops = dense::loops();
  const std::size_t m = rows_;
  double diagonal[panel][panel], gram[panel * panel];
  for (std::size_t r = 0; r < count; ++r) std::copy_n(panel_row(r) + m, r + 1, diagonal[r]);
  loops.solve_rows(column(0), stride_, inverse_diagonal_.data(), border_.data(), m, new_rows_.rows.data(),
                   panel_stride(), new_rows_.border.data(), count);
  loops.row_products(new_rows_.rows.data(), panel_stride(), m, count, gram);

  // Cholesky of the Schur complement of the new rows, row by row; a row that adds nothing is dropped.
  std::uint32_t taken = 0;
  double small[panel][panel] = {};
  for (std::size_t r = 0; r < count; ++r) {
    double* y = border_.data() + (m + r) * border;
    double pivot = diagonal[r][r] - gram[r * panel + r];
    if ((skip >> r & 1u) == 0) {
      for (std::size_t c = 0; c < r; ++c) {
        if ((taken >> c & 1u) == 0) continue;
        double value = diagonal[r][c] - gram[r * panel + c];
        for (std::size_t k = 0; k < c; ++k) value -= small[r][k] * small[c][k];
        small[r][c] = value / small[c][c];
        pivot -= small[r][c] * small[r][c];
      }
    }
    if ((skip >> r & 1u) != 0 || !(pivot > tolerance[r] * diagonal[r][r])) {
      std::fill_n(small[r], panel, 0.0);
      small[r][r] = 1;
      std::fill_n(panel_row(r), m, 0.0);
      std::fill_n(y, border, 0.0);
      continue;
    }
    taken |= 1u << r;
    small[r][r] = std::sqrt(pivot);
    const double* b = panel_border(r);
    for (std::size_t t = 0; t < border; ++t) {
      double value = b[t];
      for (std::size_t c = 0; c < r; ++c) value -= small[r][c] * border_[(m + c) * border + t];
      y[t] = value / small[r][r];
    }
  }
  for (std::size_t c = 0; c < m; ++c) {
    double* to = column(c) + m;
    for (std::size_t r = 0; r < count; ++r) to[r] = new_rows_.rows[r * panel_stride() + c];
  }
  for (std::size_t c = 0; c < count; ++c) {
    for (std::size_t r = c; r < count; ++r) column(m + c)[m + r] = small[r][c];
    inverse_diagonal_[m + c] = 1 / small[c][c];
  }
  rows_ += count;
  return taken;
}

std::pair<std::size_t, double> DenseFactor::weakest_row() const {
  std::size_t row = 0;
  for (std::size_t r = 1; r < rows_; ++r)
    if (inverse_diagonal_[r] > inverse_diagonal_[row]) row = r;
  return {row, inverse_diagonal_[row]};
}

void DenseFactor::solve(double* y, std::size_t stride) {
  dense::loops().solve_rows(column(0), stride_, inverse_diagonal_.data(), border_.data(), rows_, y, stride,
                            new_rows_.border.data(), 3);
}

void DenseFactor::solve_transposed(double* y0, double* y1, double* y2) const {
  dense::loops().solve_transposed3(column(0), stride_, inverse_diagonal_.data(), rows_, y0, y1, y2);
}

}  // namespace forefeel
