#pragma once
// Vectors of the multifrontal kernels and substitution with a factor, for right-hand sides one by one or eight side by
// side: U^T y = b, then U x = y - U_c x_c (FactorKernels in kernels.hpp).
// Include in kernel files only (see element_lanes.hpp).

#include "solver/kernels/element_lanes.hpp"

namespace forefeel {
namespace {

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
struct FrontVectors : Vectors<Real> {
  using typename Vectors<Real>::Wide, typename Vectors<Real>::Eight;
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
};

template <class Real>
struct Substitution : FrontVectors<Real> {
  using Base = FrontVectors<Real>;
  using Base::wide, Base::load_wide, Base::load_eight, Base::store;
  using typename Base::Wide, typename Base::Eight;

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

  static void forward(const FrontTree& tree, Part fronts, const Real* panels, Real* b, Real* work) {
    for (std::int64_t s = fronts.first; s < fronts.first + fronts.count; ++s) {
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

  static void backward(const FrontTree& tree, Part fronts, const Real* panels, Real* b, Real* work) {
    for (std::int64_t s = fronts.first + fronts.count - 1; s >= fronts.first; --s) {
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

  static void forward_lanes(const FrontTree& tree, Part fronts, const Real* panels, Real* b, Real* work) {
    for (std::int64_t s = fronts.first; s < fronts.first + fronts.count; ++s) {
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

  static void backward_lanes(const FrontTree& tree, Part fronts, const Real* panels, Real* b, Real* work) {
    for (std::int64_t s = fronts.first + fronts.count - 1; s >= fronts.first; --s) {
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
};

}  // namespace
}  // namespace forefeel
