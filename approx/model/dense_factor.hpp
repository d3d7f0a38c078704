#pragma once
// A Cholesky factor that grows and shrinks, with right-hand sides that follow it:
//   A = L L^T,   Y = L^-1 B,   A (m x m) symmetric positive definite, B (m x 16)
// remove() deletes rows and columns of A. With the same columns of L deleted, the rest of A is L L^T + V V^T, where the
// columns of V are the deleted ones. This is a positive update of the trailing factor. One reflection per column does
// it for many deleted columns at once. It is stable, and a downdate is never needed. append() adds up to 8 rows at the
// end by a triangular solve. Both also update Y. A deleted row remains as a hole (a row of the unit matrix) until the
// factor is compacted. Cost: O(k m^2) for k rows. Nothing allocates after construction.

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "approx/loops/aligned.hpp"
#include "approx/loops/dense_kernels.hpp"

namespace forefeel {

class DenseFactor {
 public:
  static constexpr std::size_t border = dense::border;    // columns of B
  static constexpr std::size_t panel = dense::most_rows;  // most rows that one append() takes

  explicit DenseFactor(std::size_t row_capacity = 0);

  std::size_t rows() const { return rows_; }  // m, holes included
  std::size_t row_capacity() const { return row_capacity_; }
  void clear() { rows_ = 0; }

  // Turns the rows (ascending) into holes.
  void remove(std::span<const std::size_t> removed);
  // Deletes the rows and compacts the factor: only the rows of `kept` (ascending) stay. Rows in neither list must be
  // holes.
  void remove(std::span<const std::size_t> removed, std::span<const std::size_t> kept);

  // The panel that append() reads: the new rows of A, element (r, c) for column c (new rows included), and
  // their rows of B. Row-major with stride panel_stride(); valid until the next append().
  double* panel_row(std::size_t r) { return new_rows_.rows.data() + r * panel_stride(); }
  double* panel_border(std::size_t r) { return new_rows_.border.data() + r * border; }
  std::size_t panel_stride() const { return (row_capacity_ + 3 * panel - 1) / 8 * 8; }
  // Appends `count` panel rows; rows to be left as holes are marked in skip. A row whose pivot is below
  // tolerance[r] times its diagonal entry adds nothing and becomes a hole. Returns the rows that were taken,
  // bit r for row r.
  std::uint32_t append(std::size_t count, std::uint32_t skip, const double* tolerance);

  // Y: row m has 16 entries.
  const double* border_row(std::size_t row) const { return border_.data() + row * border; }
  // The row with the largest 1 / L_rr (1 for holes), and that value.
  std::pair<std::size_t, double> weakest_row() const;
  // Solves L z = y in place for three right-hand sides of length rows() at y, y + stride and y + 2 stride.
  void solve(double* y, std::size_t stride);
  // Solves L^T z = y in place for three right-hand sides of length rows(), padded by 8.
  void solve_transposed(double* y0, double* y1, double* y2) const;

 private:
  static constexpr std::size_t most_vectors = 20;  // most vectors that wait for their update

  struct Bordered {
    AlignedArray rows, border;
  };

  void take_out(std::span<const std::size_t> removed);
  void close_up(std::span<const std::size_t> removed, std::span<const std::size_t> kept);
  dense::Kept describe(std::span<const std::size_t> kept);
  void update();

  double* column(std::size_t c) { return columns_.data() + c * stride_; }
  const double* column(std::size_t c) const { return columns_.data() + c * stride_; }

  std::size_t row_capacity_, stride_ = 0, rows_ = 0;
  AlignedArray columns_;  // L
  AlignedArray border_;   // Y
  AlignedArray inverse_diagonal_;
  Bordered new_rows_;                // the panel of append()
  Bordered vectors_;                 // V and its part of Y
  std::vector<std::size_t> starts_;  // first row of each vector
  std::vector<dense::Run> runs_;     // of close_up()
  std::vector<std::size_t> fours_;
};

}  // namespace forefeel
