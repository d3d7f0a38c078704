#pragma once
// Loops of DenseFactor (A = L L^T, Y = L^-1 B; dense_factor.hpp) over raw arrays, compiled for several
// instruction sets (instruction_set.hpp). L is column-major: entry (i, c) at l[c * stride + i], stride a
// multiple of 8. Row c of Y is at y[16 * c]. Arrays of length m start on a cache line and have room for 8
// more entries, which may be read and written.

#include <cstddef>

namespace forefeel::dense {

constexpr std::size_t border = 16;  // columns of Y
constexpr std::size_t most_rows = 8;

// A run of rows that stay when others are removed: row `from` becomes row `to`, and so on up to the next
// run's `to`.
struct Run {
  std::size_t to, from;
};
struct Kept {
  std::size_t size;
  const Run* runs;  // ascending, the last one holds the size
  std::size_t run_count;
  const std::size_t*
      fours;  // rows 4 i to 4 i + 3 were rows fours[i] to fours[i] + 3; null if rows do not move in fours
};

struct Loops {
  std::size_t most_together;  // vectors that update_columns takes
  // count <= 8 rows at rows[r * row_stride], each with 16 entries at side[16 * r]:
  //   X := X L^-T,  S := S - X Y
  void (*solve_rows)(const double* l, std::size_t stride, const double* inverse_diagonal, const double* y,
                     std::size_t m, double* rows, std::size_t row_stride, double* side, std::size_t count);
  // gram[8 * r + c] = x_r . x_c, c <= r; entries m to m + 7 of the rows become 0.
  void (*row_products)(double* rows, std::size_t row_stride, std::size_t m, std::size_t count, double* gram);
  // Positive update L L^T := L L^T + V V^T of the columns first <= c < last by `count` vectors at
  // v[t * vector_stride] with borders at side[16 * t]; one reflection per column. If count > 8, it is rounded
  // up to a multiple of 4: the additional vectors are changed too and must be zero in these columns.
  void (*update_columns)(double* l, std::size_t stride, double* inverse_diagonal, double* y,
                         std::size_t first, std::size_t last, std::size_t m, double* v,
                         std::size_t vector_stride, double* side, std::size_t count);
  // to[i] = the i-th kept row of a column, i >= begin; 0 before.
  void (*pick)(const double* column, const Kept& kept, std::size_t begin, double* to);
  // The lower triangle moves up and left.
  void (*compact)(double* l, std::size_t stride, const Kept& kept);
  // L^T z = y in place, three right-hand sides.
  void (*solve_transposed3)(const double* l, std::size_t stride, const double* inverse_diagonal,
                            std::size_t m, double* y0, double* y1, double* y2);
  // out[j * stride + r] = y[16 * r + j] for the first `count` columns (writes up to the end of the last
  // vector).
  void (*columns_of)(const double* y, std::size_t m, std::size_t count, double* out, std::size_t stride);
  // Modified Gram-Schmidt on q + 3 columns of length m at columns[j * stride], with room for three more. The
  // first q become orthonormal, with the upper triangle upper[i * q + j]. The last three become their
  // residuals (projected twice), with components right[c * q + j].
  void (*orthogonalise)(std::size_t q, std::size_t m, double* columns, std::size_t stride, double* upper,
                        double* right);
  // gram[i * q + j] = sum_r l_i[r] l_j[r], j <= i, l_i at l[i * stride]; rows of weight 0 do not count.
  void (*gram)(std::size_t q, std::size_t m, const double* l, std::size_t stride, const double* weight,
               double* gram);
  // out[c * q + j] = a_c . v_j for three vectors a and q vectors v of the same stride.
  void (*dots3)(std::size_t q, std::size_t m, const double* a, const double* v, std::size_t stride,
                double* out);
};

const Loops& loops();  // those of instruction_set_in_use()

}  // namespace forefeel::dense
