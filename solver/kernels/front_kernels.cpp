// Multifrontal factorisation and substitution, compiled once per instruction set: see kernels.hpp.
#include "solver/kernels/substitution.hpp"

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
struct Fronts : FrontVectors<Real> {
  using Base = FrontVectors<Real>;
  using Base::wide, Base::load_wide, Base::store, Base::largest;
  using typename Base::Wide;

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

  // Upper triangle of C (width columns) -= A^T B over `depth` rows of one panel, of some of its rows; row i of C starts
  // at its column i. Rows are padded to whole vectors, so the last vector may be processed whole.
  // Large fronts are processed in parts of the panel that fit into the cache.
  static constexpr std::int64_t depth_block = 96, width_block = 60 * wide;

  static void symmetric_update(std::int64_t depth, Part rows, std::int64_t width, const Real* panel,
                               std::int64_t ld, Real* c, std::int64_t ldc) {
    const std::int64_t all = rows.first + rows.count;
    for (std::int64_t p = 0; p < depth; p += depth_block)
      for (std::int64_t first = 0; first < width; first += width_block) {
        const std::int64_t deep = depth - p < depth_block ? depth - p : depth_block;
        const std::int64_t last = width - first < width_block ? width : first + width_block;
        const Real* piece = panel + p * ld;
        const std::int64_t end = all < last ? all : last;  // rows below are zero in these columns
        std::int64_t i = rows.first;
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
        symmetric_update(last - first, {0, end - last}, width - last, done, ld, panel + last * ld + last, ld);
    }
    return true;
  }

  // Cholesky of the pivot rows of a panel, in blocks of rows that update the later ones together.
  static bool eliminate(Real* panel, std::int64_t pivots, std::int64_t ld, std::int64_t width) {
    for (std::int64_t first = 0; first < pivots; first += depth_block) {
      const std::int64_t last = first + depth_block < pivots ? first + depth_block : pivots;
      if (!eliminate_rows(panel, first, last, ld, width)) return false;
      if (last < pivots)
        symmetric_update(last - first, {0, pivots - last}, width - last, panel + first * ld + last, ld,
                         panel + last * ld + last, ld);
    }
    return true;
  }

  // A large front in steps: these give the values of eliminate() and of the update matrix, whatever the parts.
  // The columns right of the diagonal block of the rows `block` of a panel, once eliminate_rows() has done that.
  static void eliminate_columns(const Front& front, Part block, Part columns, Real* panel) {
    const std::int64_t ld = front.ld, end = block.first + block.count, to = columns.first + columns.count;
    for (std::int64_t first = block.first; first < end; first += wide) {
      const std::int64_t last = first + wide < end ? first + wide : end;
      for (std::int64_t p = first; p < last; ++p) {
        Real* row = panel + p * ld;
        const Real inverse = row[p];
        for (std::int64_t j = columns.first; j < to; j += wide) store(row + j, load_wide(row + j) * inverse);
        for (std::int64_t q = p + 1; q < last; ++q) {
          Real* below = panel + q * ld;
          const Real factor = row[q];
          for (std::int64_t j = columns.first; j < to; j += wide)
            store(below + j, load_wide(below + j) - load_wide(row + j) * factor);
        }
      }
      const Real* done = panel + first * ld;
      std::int64_t i = last;
      for (; i + block_rows <= end; i += block_rows)
        update_rows<block_rows>(last - first, done + i, done, ld, panel + i * ld, ld, columns.first, to);
      for (; i < end; ++i)
        update_rows<1>(last - first, done + i, done, ld, panel + i * ld, ld, columns.first, to);
    }
  }
  static bool eliminate_diagonal(const Front& front, Part block, Real* panel) {
    const std::int64_t end = block.first + block.count;
    return eliminate_rows(panel, block.first, end, front.ld, (end + wide - 1) / wide * wide);
  }
  // Rows of the front, pivots first and then its update matrix, from which the rows `block` are subtracted.
  static void update(const Front& front, Part block, Part rows, Real* panel, Real* update) {
    const std::int64_t pivots = 3 * static_cast<std::int64_t>(front.pivots),
                       rest = 3 * static_cast<std::int64_t>(front.rest), end = block.first + block.count,
                       last = rows.first + rows.count;
    const Real* done = panel + block.first * front.ld;
    const std::int64_t in_panel = last < pivots ? last : pivots;
    if (rows.first < in_panel)
      symmetric_update(block.count, {rows.first - end, in_panel - rows.first}, front.ld - end, done + end,
                       front.ld, panel + end * front.ld + end, front.ld);
    const std::int64_t first = rows.first < pivots ? pivots : rows.first;
    if (first < last)
      symmetric_update(block.count, {first - pivots, last - first}, rest, done + pivots, front.ld, update,
                       front.update_ld);
  }

  static FOREFEEL_INLINE void add_rows(const Real* from, Real* to, std::int64_t count) {
    std::int64_t i = 0;
    for (; i + wide <= count; i += wide) store(to + i, load_wide(to + i) + load_wide(from + i));
    for (; i < count; ++i) to[i] += from[i];
  }

  // Adds the update matrix of a child at the places of its nodes in the parent: pivot rows to the panel, the
  // others to the parent's update matrix. rows: of the parent.
  static void extend_add(const FrontTree& tree, const Front& child, const Front& parent, Part rows,
                         const Real* stack_from, Real* panel, Real* update) {
    const ExtendRun* runs = tree.runs + child.runs.first;
    const std::int64_t pivots = 3 * static_cast<std::int64_t>(parent.pivots);
    for (std::int64_t r = 0; r < child.runs.count; ++r)
      for (std::int64_t i = 0; i < 3 * runs[r].length; ++i) {
        const Real* from = stack_from + (3 * runs[r].from + i) * child.update_ld;
        const std::int64_t row = 3 * runs[r].to + i;
        if (row < rows.first || row >= rows.first + rows.count) continue;
        Real* to =
            row < pivots ? panel + row * parent.ld : update + (row - pivots) * parent.update_ld - pivots;
        add_rows(from + 3 * runs[r].from + i, to + row, 3 * runs[r].length - i);
        for (std::int64_t q = r + 1; q < child.runs.count; ++q)
          add_rows(from + 3 * runs[q].from, to + 3 * runs[q].to, 3 * runs[q].length);
      }
  }

  // Rows of a front before its elimination: blocks of H and the update matrices of its children.
  static void assemble(const FrontTree& tree, const Front& front, Part rows, const double* blocks,
                       Real* panels, Real* stack) {
    const std::int64_t pivots = 3 * static_cast<std::int64_t>(front.pivots), last = rows.first + rows.count;
    Real* panel = panels + front.panel;
    Real* update = stack + front.update;
    const std::int64_t in_panel = last < pivots ? last : pivots;
    if (rows.first < in_panel)
      __builtin_memset(panel + rows.first * front.ld, 0,
                       static_cast<std::size_t>((in_panel - rows.first) * front.ld) * sizeof(Real));
    for (std::int64_t row = rows.first < pivots ? pivots : rows.first; row < last; ++row) {
      const std::int64_t i = row - pivots;  // the upper triangle, in whole vectors
      const std::int64_t from = i / wide * wide - (i < wide ? 0 : wide);
      __builtin_memset(update + i * front.update_ld + from, 0,
                       static_cast<std::size_t>(front.update_ld - from) * sizeof(Real));
    }
    for (std::int64_t i = rows.first / 3; 3 * i < in_panel; ++i)
      for (std::int64_t block = tree.row_start[front.first + i]; block < tree.row_start[front.first + i + 1];
           ++block) {
        Real* to = panel + 3 * i * front.ld + 3 * tree.place[block];
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) to[a * front.ld + b] = static_cast<Real>(blocks[9 * block + 3 * a + b]);
      }
    for (std::int64_t c = 0; c < front.children.count; ++c) {
      const Front& child = tree.fronts[tree.children[front.children.first + c]];
      extend_add(tree, child, front, rows, stack + child.update, panel, update);
    }
  }

  static bool factor(const FrontTree& tree, Part fronts, const double* blocks, Real* panels, Real* stack) {
    for (std::int64_t s = fronts.first; s < fronts.first + fronts.count; ++s) {
      const Front& front = tree.fronts[s];
      const std::int64_t pivots = 3 * static_cast<std::int64_t>(front.pivots),
                         rest = 3 * static_cast<std::int64_t>(front.rest);
      Real* panel = panels + front.panel;
      assemble(tree, front, {0, pivots + rest}, blocks, panels, stack);
      if (!eliminate(panel, pivots, front.ld, front.ld)) return false;
      symmetric_update(pivots, {0, rest}, rest, panel + pivots, front.ld, stack + front.update,
                       front.update_ld);
    }
    return true;
  }

  using Solve = Substitution<Real>;
  static constexpr FactorKernels<Real> table{
      factor,      assemble,       eliminate_diagonal, eliminate_columns,    update,
      depth_block, Solve::forward, Solve::backward,    Solve::forward_lanes, Solve::backward_lanes};
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
