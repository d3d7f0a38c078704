// Multifrontal factorisation and substitution, compiled once per instruction set: see kernels.hpp.
#include "solver/kernels/element_lanes.hpp"

#ifndef FOREFEEL_ISA
#define FOREFEEL_ISA portable
#endif

namespace forefeel {
namespace {

#if defined(__AVX512F__)
constexpr int block_rows = 8, block_vectors = 3;
#elif defined(__AVX2__)
constexpr int block_rows = 6, block_vectors = 1;
#else
constexpr int block_rows = 2, block_vectors = 1;
#endif

template <class Real>
struct Vectors;
template <>
struct Vectors<double> {
  using Wide = Lanes;
  using Eight = Lanes;
  static constexpr double largest = 1e300;  // of a pivot
};
template <>
struct Vectors<float> {
  using Wide = float __attribute__((vector_size(64)));
  using Eight = float __attribute__((vector_size(32)));
  static constexpr float largest = 1e37F;
};

template <class Real>
struct Fronts : Vectors<Real> {
  using typename Vectors<Real>::Wide, typename Vectors<Real>::Eight;
  using Vectors<Real>::largest;
  static constexpr int wide = row_padding<Real>;

  static FOREFEEL_INLINE Wide load_wide(const Real* p) {
    Wide v;
    __builtin_memcpy(&v, p, sizeof v);
    return v;
  }
  static FOREFEEL_INLINE Eight load_eight(const Real* p) {
    Eight v;
    __builtin_memcpy(&v, p, sizeof v);
    return v;
  }
  template <class V>
  static FOREFEEL_INLINE void store(Real* p, V v) {
    __builtin_memcpy(p, &v, sizeof v);
  }

  // C[i][j .. j + v vectors) -= sum_p A[p][i] B[p][j .. ), i < rows: the inner kernel; this part of C stays in
  // registers.
  template <int rows, int vectors>
  static FOREFEEL_INLINE void rank_update(std::int64_t depth, const Real* a, const Real* b, std::int64_t ld,
                                          Real* c, std::int64_t ldc) {
    Wide sum[rows][vectors];
    for (int i = 0; i < rows; ++i)
      for (int v = 0; v < vectors; ++v) sum[i][v] = load_wide(c + i * ldc + v * wide);
    for (std::int64_t p = 0; p < depth; ++p, a += ld, b += ld) {
      Wide right[vectors];
      for (int v = 0; v < vectors; ++v) right[v] = load_wide(b + v * wide);
      for (int i = 0; i < rows; ++i)
        for (int v = 0; v < vectors; ++v) sum[i][v] -= right[v] * a[i];
    }
    for (int i = 0; i < rows; ++i)
      for (int v = 0; v < vectors; ++v) store(c + i * ldc + v * wide, sum[i][v]);
  }

  template <int rows>
  static FOREFEEL_INLINE void update_rows(std::int64_t depth, const Real* a, const Real* b, std::int64_t ld,
                                          Real* c, std::int64_t ldc, std::int64_t from, std::int64_t width) {
    std::int64_t j = from;
    for (; j + block_vectors * wide <= width; j += block_vectors * wide)
      rank_update<rows, block_vectors>(depth, a, b + j, ld, c + j, ldc);
    for (; j < width; j += wide) rank_update<rows, 1>(depth, a, b + j, ld, c + j, ldc);
  }

  // Upper triangle of C (rows x width) -= A^T B over `depth` rows of one panel; row i of C starts at its column
  // i. Rows are padded to whole vectors, so the last vector may be processed whole.
  // Large fronts are processed in parts of the panel that fit into the cache.
  static constexpr std::int64_t depth_block = 96, width_block = 60 * wide;

  static void symmetric_update(std::int64_t depth, std::int64_t rows, std::int64_t width, const Real* panel,
                               std::int64_t ld, Real* c, std::int64_t ldc) {
    for (std::int64_t p = 0; p < depth; p += depth_block)
      for (std::int64_t first = 0; first < width; first += width_block) {
        const std::int64_t deep = depth - p < depth_block ? depth - p : depth_block;
        const std::int64_t last = width - first < width_block ? width : first + width_block;
        const Real* piece = panel + p * ld;
        const std::int64_t end = rows < last ? rows : last;  // rows below are zero in these columns
        std::int64_t i = 0;
        const auto from = [&](std::int64_t row) {
          const std::int64_t start = row / wide * wide;
          return start < first ? first : start;
        };
        for (; i + block_rows <= end; i += block_rows)
          update_rows<block_rows>(deep, piece + i, piece, ld, c + i * ldc, ldc, from(i), last);
        for (; i + 2 <= end; i += 2)
          update_rows<2>(deep, piece + i, piece, ld, c + i * ldc, ldc, from(i), last);
        for (; i < end; ++i) update_rows<1>(deep, piece + i, piece, ld, c + i * ldc, ldc, from(i), last);
      }
  }

  // Cholesky of rows begin to end of a panel, one vector's width at a time. `width` and `begin` are multiples of it.
  static bool eliminate_rows(Real* panel, std::int64_t begin, std::int64_t end, std::int64_t ld,
                             std::int64_t width) {
    for (std::int64_t first = begin; first < end; first += wide) {
      const std::int64_t last = first + wide < end ? first + wide : end;
      for (std::int64_t p = first; p < last; ++p) {
        Real* row = panel + p * ld;
        const Real pivot = row[p];
        if (!(pivot > 0) || !(pivot < largest)) return false;
        const Real inverse = static_cast<Real>(1.0 / __builtin_sqrt(static_cast<double>(pivot)));
        for (std::int64_t j = p / wide * wide; j < width; j += wide)
          store(row + j, load_wide(row + j) * inverse);
        for (std::int64_t q = p + 1; q < last; ++q) {
          Real* to = panel + q * ld;
          const Real factor = row[q];
          for (std::int64_t j = q / wide * wide; j < width; j += wide)
            store(to + j, load_wide(to + j) - load_wide(row + j) * factor);
        }
        row[p] = inverse;
      }
      const Real* done = panel + first * ld + last;
      if (last < end)
        symmetric_update(last - first, end - last, width - last, done, ld, panel + last * ld + last, ld);
    }
    return true;
  }

  // Cholesky of the pivot rows of a panel, in blocks of rows that update the later ones together.
  static bool eliminate(Real* panel, std::int64_t pivots, std::int64_t ld, std::int64_t width) {
    for (std::int64_t first = 0; first < pivots; first += depth_block) {
      const std::int64_t last = first + depth_block < pivots ? first + depth_block : pivots;
      if (!eliminate_rows(panel, first, last, ld, width)) return false;
      if (last < pivots)
        symmetric_update(last - first, pivots - last, width - last, panel + first * ld + last, ld,
                         panel + last * ld + last, ld);
    }
    return true;
  }

  static FOREFEEL_INLINE void add_rows(const Real* from, Real* to, std::int64_t count) {
    std::int64_t i = 0;
    for (; i + wide <= count; i += wide) store(to + i, load_wide(to + i) + load_wide(from + i));
    for (; i < count; ++i) to[i] += from[i];
  }

  // Adds the update matrix of a child at the places of its nodes in the parent: pivot rows to the panel, the
  // others to the parent's update matrix.
  static void extend_add(const FrontTree& tree, const Front& child, const Front& parent,
                         const Real* stack_from, Real* panel, Real* update) {
    const ExtendRun* runs = tree.runs + child.runs.first;
    const std::int64_t pivots = 3 * static_cast<std::int64_t>(parent.pivots);
    for (std::int64_t r = 0; r < child.runs.count; ++r)
      for (std::int64_t i = 0; i < 3 * runs[r].length; ++i) {
        const Real* from = stack_from + (3 * runs[r].from + i) * child.update_ld;
        const std::int64_t row = 3 * runs[r].to + i;
        Real* to =
            row < pivots ? panel + row * parent.ld : update + (row - pivots) * parent.update_ld - pivots;
        add_rows(from + 3 * runs[r].from + i, to + row, 3 * runs[r].length - i);
        for (std::int64_t q = r + 1; q < child.runs.count; ++q)
          add_rows(from + 3 * runs[q].from, to + 3 * runs[q].to, 3 * runs[q].length);
      }
  }

  static bool factor(const FrontTree& tree, const double* blocks, Real* panels, Real* stack, double* corner) {
    const double* last = blocks + 9 * tree.row_start[tree.free_nodes];
    for (int i = 0; i < 9; ++i) corner[i] = last[i];
    for (std::int64_t s = 0; s < tree.count; ++s) {
      const Front& front = tree.fronts[s];
      const std::int64_t pivots = 3 * static_cast<std::int64_t>(front.pivots),
                         rest = 3 * static_cast<std::int64_t>(front.rest);
      Real* panel = panels + front.panel;
      Real* update = stack + front.update;
      __builtin_memset(panel, 0, static_cast<std::size_t>(pivots * front.ld) * sizeof(Real));
      for (std::int64_t i = 0; i < rest; ++i) {  // the upper triangle, in whole vectors
        const std::int64_t from = i / wide * wide - (i < wide ? 0 : wide);
        __builtin_memset(update + i * front.update_ld + from, 0,
                         static_cast<std::size_t>(front.update_ld - from) * sizeof(Real));
      }
      for (std::int64_t i = 0; i < front.pivots; ++i)
        for (std::int64_t block = tree.row_start[front.first + i];
             block < tree.row_start[front.first + i + 1]; ++block) {
          Real* to = panel + 3 * i * front.ld + 3 * tree.place[block];
          for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
              to[a * front.ld + b] = static_cast<Real>(blocks[9 * block + 3 * a + b]);
        }
      for (std::int64_t c = 0; c < front.children.count; ++c) {
        const Front& child = tree.fronts[tree.children[front.children.first + c]];
        extend_add(tree, child, front, stack + child.update, panel, update);
      }
      if (!eliminate(panel, pivots, front.ld, front.ld)) return false;
      symmetric_update(pivots, rest, rest, panel + pivots, front.ld, update, front.update_ld);
      if (front.parent < 0 && front.rest > 0)
        for (int i = 0; i < 9; ++i) {
          const int a = i / 3 < i % 3 ? i / 3 : i % 3, b = i / 3 + i % 3 - a;
          corner[i] += update[a * front.update_ld + b];
        }
    }
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < a; ++b) corner[3 * a + b] = corner[3 * b + a];
    return true;
  }

  // Front s in a substitution: its panel, the local nodes of its rest, and its part of `lanes` right-hand sides.
  struct Solving {
    const Front& front;
    std::int64_t pivots, rest;  // rows
    const Real* panel;
    const std::int32_t* rows;
    Real* x;
  };
  static FOREFEEL_INLINE Solving solving(const FrontTree& tree, std::int64_t s, const Real* panels, Real* b,
                                         std::int64_t lanes) {
    const Front& front = tree.fronts[s];
    return {front,
            3 * std::int64_t{front.pivots},
            3 * std::int64_t{front.rest},
            panels + front.panel,
            tree.rows + front.rows,
            b + 3 * std::int64_t{front.first} * lanes};
  }
  // take(i, row) for each of the `rest` rows, and its row in a local vector.
  template <class Take>
  static FOREFEEL_INLINE void each_row(const std::int32_t* node, std::int64_t rest, const Take& take) {
    for (std::int64_t i = 0; i < rest; i += 3, ++node)
      for (int a = 0; a < 3; ++a) take(i + a, 3 * std::int64_t{*node} + a);
  }

  static void forward(const FrontTree& tree, const Real* panels, Real* b, Real* work) {
    for (std::int64_t s = 0; s < tree.count; ++s) {
      const auto [front, pivots, rest, panel, rows, x] = solving(tree, s, panels, b, 1);
      for (std::int64_t j = 0; j < rest; j += wide) store(work + j, Wide{});
      for (std::int64_t p = 0; p < pivots; ++p) {
        const Real* row = panel + p * front.ld;
        const Real value = x[p] *= row[p];
        for (std::int64_t q = p + 1; q < pivots; ++q) x[q] -= row[q] * value;
      }
      std::int64_t p = 0;
      for (; p + 4 <= pivots; p += 4) {
        const Real* row = panel + p * front.ld + pivots;
        for (std::int64_t j = 0; j < rest; j += wide) {
          Wide sum = load_wide(work + j);
          for (int i = 0; i < 4; ++i) sum += load_wide(row + i * front.ld + j) * x[p + i];
          store(work + j, sum);
        }
      }
      for (; p < pivots; ++p)
        for (std::int64_t j = 0; j < rest; j += wide)
          store(work + j, load_wide(work + j) + load_wide(panel + p * front.ld + pivots + j) * x[p]);
      each_row(rows, rest, [&](std::int64_t i, std::int64_t row) { b[row] -= work[i]; });
    }
  }

  static void backward(const FrontTree& tree, const Real* panels, Real* b, Real* work) {
    for (std::int64_t s = tree.count - 1; s >= 0; --s) {
      const auto [front, pivots, rest, panel, rows, x] = solving(tree, s, panels, b, 1);
      each_row(rows, rest, [&](std::int64_t i, std::int64_t row) { work[i] = b[row]; });
      const std::int64_t whole = rest / wide * wide;
      for (std::int64_t p = pivots - 1; p >= 0; --p) {
        const Real* row = panel + p * front.ld;
        Wide sum{};
        for (std::int64_t j = 0; j < whole; j += wide)
          sum += load_wide(row + pivots + j) * load_wide(work + j);
        Real value = x[p];
        for (std::int64_t j = whole; j < rest; ++j) value -= row[pivots + j] * work[j];
        for (int i = 0; i < wide; ++i) value -= sum[i];
        for (std::int64_t q = p + 1; q < pivots; ++q) value -= row[q] * x[q];
        x[p] = value * row[p];
      }
    }
  }

  // sum_i -= panel[p][i] x_p for `rows` entries side by side, eight right-hand sides each.
  template <int rows>
  static FOREFEEL_INLINE void forward_piece(std::int64_t pivots, const Real* panel, std::int64_t ld,
                                            const Real* x, Real* out) {
    Eight sum[rows];
    for (int i = 0; i < rows; ++i) sum[i] = load_eight(out + i * lane_count);
    for (std::int64_t p = 0; p < pivots; ++p) {
      const Eight value = load_eight(x + p * lane_count);
      for (int i = 0; i < rows; ++i) sum[i] -= value * panel[p * ld + i];
    }
    for (int i = 0; i < rows; ++i) store(out + i * lane_count, sum[i]);
  }

  static void forward_lanes(const FrontTree& tree, const Real* panels, Real* b, Real* work) {
    for (std::int64_t s = 0; s < tree.count; ++s) {
      const auto [front, pivots, rest, panel, rows, x] = solving(tree, s, panels, b, lane_count);
      for (std::int64_t first = 0; first < pivots; first += 6) {
        const std::int64_t last = first + 6 < pivots ? first + 6 : pivots;
        for (std::int64_t p = first; p < last; ++p) {
          const Eight value = load_eight(x + p * lane_count) * panel[p * front.ld + p];
          store(x + p * lane_count, value);
          for (std::int64_t q = p + 1; q < last; ++q)
            store(x + q * lane_count, load_eight(x + q * lane_count) - value * panel[p * front.ld + q]);
        }
        std::int64_t q = last;
        for (; q + 6 <= pivots; q += 6)
          forward_piece<6>(last - first, panel + first * front.ld + q, front.ld, x + first * lane_count,
                           x + q * lane_count);
        for (; q < pivots; ++q)
          forward_piece<1>(last - first, panel + first * front.ld + q, front.ld, x + first * lane_count,
                           x + q * lane_count);
      }
      each_row(rows, rest, [&](std::int64_t i, std::int64_t row) {
        store(work + i * lane_count, load_eight(b + row * lane_count));
      });
      std::int64_t i = 0;
      for (; i + 12 <= rest; i += 12)
        forward_piece<12>(pivots, panel + pivots + i, front.ld, x, work + i * lane_count);
      for (; i + 3 <= rest; i += 3)
        forward_piece<3>(pivots, panel + pivots + i, front.ld, x, work + i * lane_count);
      each_row(rows, rest, [&](std::int64_t k, std::int64_t row) {
        store(b + row * lane_count, load_eight(work + k * lane_count));
      });
    }
  }

  // out_p -= sum_q panel[p][q] x_q for `rows` pivots side by side.
  template <int rows>
  static FOREFEEL_INLINE void backward_piece(std::int64_t count, const Real* panel, std::int64_t ld,
                                             const Real* x, Real* out) {
    Eight sum[rows];
    for (int i = 0; i < rows; ++i) sum[i] = load_eight(out + i * lane_count);
    for (std::int64_t q = 0; q < count; ++q) {
      const Eight value = load_eight(x + q * lane_count);
      for (int i = 0; i < rows; ++i) sum[i] -= value * panel[i * ld + q];
    }
    for (int i = 0; i < rows; ++i) store(out + i * lane_count, sum[i]);
  }

  static void backward_lanes(const FrontTree& tree, const Real* panels, Real* b, Real* work) {
    for (std::int64_t s = tree.count - 1; s >= 0; --s) {
      const auto [front, pivots, rest, panel, rows, x] = solving(tree, s, panels, b, lane_count);
      each_row(rows, rest, [&](std::int64_t i, std::int64_t row) {
        store(work + i * lane_count, load_eight(b + row * lane_count));
      });
      std::int64_t p = 0;
      for (; p + 6 <= pivots; p += 6)
        backward_piece<6>(rest, panel + p * front.ld + pivots, front.ld, work, x + p * lane_count);
      for (; p < pivots; ++p)
        backward_piece<1>(rest, panel + p * front.ld + pivots, front.ld, work, x + p * lane_count);
      // pivots is a multiple of three: blocks of three from the end
      for (std::int64_t first = pivots - 3; first >= 0; first -= 3) {
        backward_piece<3>(pivots - first - 3, panel + first * front.ld + first + 3, front.ld,
                          x + (first + 3) * lane_count, x + first * lane_count);
        for (std::int64_t q = first + 2; q >= first; --q) {
          Eight value = load_eight(x + q * lane_count);
          for (std::int64_t r = q + 1; r < first + 3; ++r)
            value -= load_eight(x + r * lane_count) * panel[q * front.ld + r];
          store(x + q * lane_count, value * panel[q * front.ld + q]);
        }
      }
    }
  }

  static constexpr FactorKernels<Real> table{factor, forward, backward, forward_lanes, backward_lanes};
};

void dot_lanes(std::int64_t rows, const double* a, const double* b, double* out) {
  Lanes sum[4]{};
  std::int64_t i = 0;
  for (; i + 4 <= rows; i += 4)
    for (int k = 0; k < 4; ++k) sum[k] += load(a + (i + k) * lane_count) * load(b + (i + k) * lane_count);
  for (; i < rows; ++i) sum[0] += load(a + i * lane_count) * load(b + i * lane_count);
  store(out, (sum[0] + sum[1]) + (sum[2] + sum[3]));
}

void add_lanes(std::int64_t rows, const double* factor, const double* x, double* y) {
  const Lanes f = load(factor);
  for (std::int64_t i = 0; i < rows; ++i)
    store(y + i * lane_count, load(y + i * lane_count) + f * load(x + i * lane_count));
}

void cross_lanes(std::int64_t rows, const double* a, std::int64_t row_step, std::int64_t field_step,
                 const double* b, double* out) {
  Lanes sum[3]{};
  for (std::int64_t i = 0; i < rows; ++i)
    for (int c = 0; c < 3; ++c) sum[c] += a[i * row_step + c * field_step] * load(b + i * lane_count);
  for (int c = 0; c < 3; ++c) store(out + c * lane_count, sum[c]);
}

}  // namespace

namespace FOREFEEL_ISA {
extern const FrontKernels front_kernels;
const FrontKernels front_kernels{Fronts<double>::table, Fronts<float>::table, dot_lanes, add_lanes,
                                 cross_lanes};
}  // namespace FOREFEEL_ISA
}  // namespace forefeel
