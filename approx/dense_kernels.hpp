#pragma once
// Leaf loops of DenseFactor over raw arrays, compiled for several instruction sets (geometry/simd.hpp).
// L is column-major: entry (i, c) at l[c * stride + i]. Loops may touch up to 8 entries past the last row.

#include <cstddef>

namespace forefeel::dense {

// X (m columns of P = 4 or 8 values): X := X L^-T, column by column.
void solve_panel4(const double* l, std::size_t stride, const double* inverse_diagonal, std::size_t m, double* x);
void solve_panel8(const double* l, std::size_t stride, const double* inverse_diagonal, std::size_t m, double* x);
// gram (P x P) = sum_c X_c X_c^T;  side (P x 16) = sum_c X_c Y_c^T over the first 8 * halves of Y's 16 entries,
// Y_c at y[c * stride].
void panel_products4(const double* x, const double* y, std::size_t stride, std::size_t m, int halves, double* gram,
                     double* side);
void panel_products8(const double* x, const double* y, std::size_t stride, std::size_t m, int halves, double* gram,
                     double* side);
// Positive rank-one updates of the columns first <= c < last by `count` (1 to 4) vectors v_t (stride vector_stride):
// L L^T := L L^T + sum v v^T below. The 16 border entries of column c lie at l[c * stride - 16], those of v_t at v_t[-16].
void rotate_columns(double* l, std::size_t stride, double* inverse_diagonal, std::size_t first, std::size_t last,
                    std::size_t m, double* vectors, std::size_t vector_stride, int count);
// L^T z = y in place, three right-hand sides.
void solve_transposed3(const double* l, std::size_t stride, const double* inverse_diagonal, std::size_t m, double* y0,
                       double* y1, double* y2);
// Rows of X (row-major, 8 or 4 rows) to columns.
void transpose_panel(const double* rows, std::size_t row_stride, std::size_t p, std::size_t m, double* x);

}  // namespace forefeel::dense
