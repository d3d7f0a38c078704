#pragma once
// Leaf loops of DenseFactor over raw arrays, compiled for several instruction sets (geometry/simd.hpp).
// L is column-major: entry (i, c) at l[c * stride + i]. Loops may touch up to 8 entries past the last row.

#include <cstddef>

namespace forefeel::dense {

// X (m columns of P = 4 or 8 values): X := X L^-T, column by column.
void solve_panel4(const double* l, std::size_t stride, const double* inverse_diagonal, std::size_t m,
                  double* x);
void solve_panel8(const double* l, std::size_t stride, const double* inverse_diagonal, std::size_t m,
                  double* x);
// gram (P x P) = sum_c X_c X_c^T;  side (P x 16) = sum_c X_c Y_c^T over the first 8 * halves of Y's 16
// entries, Y_c at y[c * stride].
void panel_products4(const double* x, const double* y, std::size_t stride, std::size_t m, int halves,
                     double* gram, double* side);
void panel_products8(const double* x, const double* y, std::size_t stride, std::size_t m, int halves,
                     double* gram, double* side);
// Positive rank-one updates of the columns first <= c < last by `count` (1 to 4) vectors v_t (stride
// vector_stride): L L^T := L L^T + sum v v^T below. The 16 border entries of column c lie at l[c * stride -
// 16], those of v_t at v_t[-16].
void rotate_columns(double* l, std::size_t stride, double* inverse_diagonal, std::size_t first,
                    std::size_t last, std::size_t m, double* vectors, std::size_t vector_stride, int count);
// L^T z = y in place, three right-hand sides.
void solve_transposed3(const double* l, std::size_t stride, const double* inverse_diagonal, std::size_t m,
                       double* y0, double* y1, double* y2);
// Modified Gram-Schmidt on q + 3 columns of length m (each followed by 8 entries of room) at columns[j *
// stride]: the first q become orthonormal with upper triangle upper[i * q + j], the last three their own
// residuals (taken twice), and right[c * q + j] their components.
void orthogonalise(std::size_t q, std::size_t m, double* columns, std::size_t stride, double* upper,
                   double* right);
// gram[i * q + j] = sum_r l_i[r] l_j[r], j <= i, l_i at l[i * stride]; rows of weight 0 do not count.
void gram(std::size_t q, std::size_t m, const double* l, std::size_t stride, const double* weight,
          double* gram);
// Rows of X (row-major, 8 or 4 rows) to columns.
void transpose_panel(const double* rows, std::size_t row_stride, std::size_t p, std::size_t m, double* x);

}  // namespace forefeel::dense
