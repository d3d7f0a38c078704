// Products of columns: solve with L^T, Gram-Schmidt, Gram matrix. Compiled once per instruction set.
#include "approx/loops/dense_parts.hpp"

namespace forefeel::FOREFEEL_ISA {

void solve_transposed3(const double* l, std::size_t stride, const double* inverse, std::size_t m, double* y0,
                       double* y1, double* y2) {
  double* __restrict y[3] = {y0, y1, y2};
  std::size_t end = m;
  if (const std::size_t odd = m % 4; odd != 0) {  // the last columns one by one; the others in fours
    for (std::size_t c = m; c-- > m - odd;)
      for (auto* yk : y) {
        double value = yk[c];
        for (std::size_t i = c + 1; i < m; ++i) value -= l[c * stride + i] * yk[i];
        yk[c] = value * inverse[c];
      }
    end = m - odd;
  }
  for (auto* yk : y)
    for (std::size_t i = m; i < m + 8; ++i) yk[i] = 0;
  for (std::size_t c = end; c >= 4; c -= 4) {
    const std::size_t c0 = c - 4;
    const double* __restrict b = l + c0 * stride;
    Pack sum[3][4] = {};
    const auto add = [&](std::size_t i, Pack x0, Pack x1, Pack x2) __attribute__((always_inline)) {
      for (std::size_t t = 0; t < 4; ++t) {
        const Pack value = load(b + t * stride + i);
        sum[0][t] += value * x0;
        sum[1][t] += value * x1;
        sum[2][t] += value * x2;
      }
    };
    // The four entries just solved come last, so that the others need not wait for them. They are read by one load as
    // wide as their store.
    const std::size_t whole = width == 8 ? (c + 11) / 8 * 8 : c + 4;
    for (std::size_t i = whole; i < m; i += width) add(i, load(y[0] + i), load(y[1] + i), load(y[2] + i));
    for (std::size_t i = whole; i > c;) {
      i -= 4;
      if (i < m)
        for (std::size_t part = i; part < i + 4; part += width)
          add(part, load_four(y[0] + part), load_four(y[1] + part), load_four(y[2] + part));
    }
    const double* __restrict b1 = b + stride;
    const double* __restrict b2 = b1 + stride;
    for (std::size_t k = 0; k < 3; ++k) {
      double s[4];
      sums_of(sum[k], s);
      double* __restrict z = y[k] + c0;
      const double z3 = (z[3] - s[3]) * inverse[c0 + 3];
      const double z2 = (z[2] - s[2] - b2[c0 + 3] * z3) * inverse[c0 + 2];
      const double z1 = (z[1] - s[1] - b1[c0 + 3] * z3 - b1[c0 + 2] * z2) * inverse[c0 + 1];
      const double z0 = (z[0] - s[0] - b[c0 + 3] * z3 - b[c0 + 2] * z2 - b[c0 + 1] * z1) * inverse[c0];
      store_four(z, z0, z1, z2, z3);
    }
  }
}

namespace {

// One step of modified Gram-Schmidt on a column c and the K columns after it. products: in, the products of c
// with itself and with these; out, those of the next column with itself and the ones after it. Removes c's
// component from the others and normalises c, in one sweep.
template <std::size_t K>
FOREFEEL_INLINE void take_out(std::size_t m, double* __restrict c, std::size_t stride, double* products) {
  const double unit = 1 / __builtin_sqrt(products[0]), squared = 1 / products[0];
  Pack share[K], sum[K] = {};
  for (std::size_t t = 0; t < K; ++t) share[t] = same(products[t + 1] * squared);
  for (std::size_t r = 0; r < m; r += width) {
    const Pack x = load(c + r), next = load(c + stride + r) - share[0] * x;
    store(c + r, x * unit);
    store(c + stride + r, next);
    sum[0] += next * next;
    for (std::size_t t = 1; t < K; ++t) {
      const Pack other = load(c + (t + 1) * stride + r) - share[t] * x;
      store(c + (t + 1) * stride + r, other);
      sum[t] += next * other;
    }
  }
  constexpr std::size_t whole = K / 4 * 4;
  for (std::size_t t = 0; t < whole; t += 4) sums_of(sum + t, products + t);
  for (std::size_t t = whole; t < K; ++t) products[t] = sum_of(sum[t]);
}

// Projects three columns once more onto the complement of Q orthonormal ones; adds the components to right[c
// * q + j].
template <std::size_t Q>
FOREFEEL_INLINE void take_out_again(std::size_t q, std::size_t m, const double* __restrict columns,
                                    std::size_t stride, double* __restrict rest, double* right) {
  Pack sum[3][Q] = {};
  for (std::size_t r = 0; r < m; r += width) {
    const Pack x[3] = {load(rest + r), load(rest + stride + r), load(rest + 2 * stride + r)};
    for (std::size_t j = 0; j < Q; ++j) {
      const Pack unit = load(columns + j * stride + r);
      for (std::size_t c = 0; c < 3; ++c) sum[c][j] += unit * x[c];
    }
  }
  double along[3][Q];
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t j = 0; j < Q; ++j) right[c * q + j] += along[c][j] = sum_of(sum[c][j]);
  for (std::size_t r = 0; r < m; r += width)
    for (std::size_t c = 0; c < 3; ++c) {
      Pack x = load(rest + c * stride + r);
      for (std::size_t j = 0; j < Q; ++j) x -= along[c][j] * load(columns + j * stride + r);
      store(rest + c * stride + r, x);
    }
}

}  // namespace

void orthogonalise(std::size_t q, std::size_t m, double* columns, std::size_t stride, double* upper,
                   double* right) {
  const std::size_t all = q + 3;
  for (std::size_t j = 0; j < all + 1; ++j)
    for (std::size_t r = m; r < m + 8; ++r) columns[j * stride + r] = 0;
  double products[16];
  for (std::size_t k = 0; k < all; ++k) {
    Pack sum = {};
    for (std::size_t r = 0; r < m; r += width) sum += load(columns + r) * load(columns + k * stride + r);
    products[k] = sum_of(sum);
  }
  for (std::size_t j = 0; j < q; ++j) {
    const double length = __builtin_sqrt(products[0]);
    upper[j * q + j] = length;
    for (std::size_t k = j + 1; k < all; ++k)
      (k < q ? upper[j * q + k] : right[(k - q) * q + j]) = products[k - j] / length;
    double* c = columns + j * stride;
    with_count<3, 12>(
        all - j - 1, [&](auto after)
                         __attribute__((always_inline)) { take_out<after>(m, c, stride, products); });
  }
  double* rest = columns + q * stride;
  if (q == 10) {
    take_out_again<5>(q, m, columns, stride, rest, right);
    take_out_again<5>(q, m, columns + 5 * stride, stride, rest, right + 5);
  } else if (q == 4) {
    take_out_again<4>(q, m, columns, stride, rest, right);
  } else {
    take_out_again<1>(q, m, columns, stride, rest, right);
  }
}

// Rows i and i + 1 of the products with all columns before them, four columns at a time.
void gram(std::size_t q, std::size_t m, const double* l, std::size_t stride, const double* weight,
          double* out) {
  for (std::size_t i = 0; i < q; i += 2) {
    const double* a[2] = {l + i * stride, l + (i + 1 < q ? i + 1 : i) * stride};
    for (std::size_t j = 0; j < q && j < i + 2; j += 4) {
      const double* b[4];
      for (std::size_t t = 0; t < 4; ++t) b[t] = l + (j + t < q ? j + t : j) * stride;
      Pack sum[2][4] = {};
      for (std::size_t r = 0; r < m; r += width) {
        const Pack w = load(weight + r), w2 = w * w;
        const Pack x[2] = {w2 * load(a[0] + r), w2 * load(a[1] + r)};
        for (std::size_t t = 0; t < 4; ++t) {
          const Pack y = load(b[t] + r);
          for (std::size_t s = 0; s < 2; ++s) sum[s][t] += x[s] * y;
        }
      }
      for (std::size_t s = 0; s < 2; ++s) {
        double four[4];
        sums_of(sum[s], four);
        for (std::size_t t = 0; t < 4 && i + s < q && j + t <= i + s; ++t) out[(i + s) * q + j + t] = four[t];
      }
    }
  }
}

void dots3(std::size_t q, std::size_t m, const double* a, const double* v, std::size_t stride, double* out) {
  for (std::size_t j = 0; j < q; ++j) {
    Pack sum[3] = {};
    for (std::size_t r = 0; r < m; r += width) {
      const Pack x = load(v + j * stride + r);
      for (std::size_t c = 0; c < 3; ++c) sum[c] += x * load(a + c * stride + r);
    }
    for (std::size_t c = 0; c < 3; ++c) out[c * q + j] = sum_of(sum[c]);
  }
}

}  // namespace forefeel::FOREFEEL_ISA
