// Compiled once per instruction set.
#include "approx/kernel_sums.hpp"

#include "approx/lanes.hpp"

namespace forefeel::FOREFEEL_ISA {
namespace {

constexpr double tiny = 1e-200;  // added to r^2, so that its root has an inverse

FOREFEEL_INLINE Pack divided_root(Pack x) {
#if defined(__AVX512F__)
  return reinterpret_cast<Pack>(_mm512_sqrt_pd(reinterpret_cast<__m512d>(x)));
#elif defined(__AVX2__)
  return reinterpret_cast<Pack>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(x)));
#elif defined(__SSE2__)
  return reinterpret_cast<Pack>(_mm_sqrt_pd(reinterpret_cast<__m128d>(x)));
#else
  for (std::size_t i = 0; i < width; ++i) x[i] = __builtin_sqrt(x[i]);
  return x;
#endif
}

// sqrt(x), x >= tiny. The divider is the narrowest unit of the processor, so of three vectors (`turn` counts
// them) two take the estimate of AVX-512, of relative error below 2^-14, with the series of (1 - e)^(-1/2) to
// e^3: right to an ulp.
FOREFEEL_INLINE Pack root(Pack x, [[maybe_unused]] int turn) {
#if defined(__AVX512F__)
  if (turn != 0) {
    const Pack y = reinterpret_cast<Pack>(_mm512_rsqrt14_pd(reinterpret_cast<__m512d>(x)));
    const Pack g = x * y, e = 1.0 - g * y;
    return g + (g * e) * (0.5 + e * (0.375 + 0.3125 * e));
  }
#endif
  return divided_root(x);
}

template <int K>
FOREFEEL_INLINE Pack power_of(Pack r2, Pack r) {
  if constexpr (K == -1) return 1.0 / (r > 1e-99 ? r : same(1e-99));
  if constexpr (K == 0) return same(1);
  if constexpr (K == 1) return r;
  if constexpr (K == 3) return r * r2;
  if constexpr (K == 5) return r * r2 * r2;
}

struct Distance {
  Pack dx, dy, dz, r2, r;
};

FOREFEEL_INLINE Distance distance(const double* data, std::size_t stride, std::size_t i, const Pack y[3],
                                  int turn) {
  Distance d;
  d.dx = y[0] - load(data + i);
  d.dy = y[1] - load(data + stride + i);
  d.dz = y[2] - load(data + 2 * stride + i);
  d.r2 = d.dz * d.dz + (d.dy * d.dy + (d.dx * d.dx + tiny));
  d.r = root(d.r2, turn);
  return d;
}

template <int K>
FOREFEEL_INLINE void add_plain(const double* data, std::size_t stride, std::size_t i, const Pack y[3],
                               int turn, Pack s[3]) {
  const Distance d = distance(data, stride, i, y, turn);
  const Pack phi = power_of<K>(d.r2, d.r);
  for (std::size_t c = 0; c < 3; ++c) s[c] += phi * load(data + (3 + c) * stride + i);
}

template <int K>
FOREFEEL_INLINE void add_hermite(const double* data, std::size_t stride, std::size_t i, const Pack y[3],
                                 int turn, Pack s[3]) {
  const Distance d = distance(data, stride, i, y, turn);
  const Pack low = power_of<K - 2>(d.r2, d.r);  // phi = low r^2
  const Pack phi = low * d.r2, slope = -double(K) * low;
  const Pack gx = slope * d.dx, gy = slope * d.dy, gz = slope * d.dz;
  for (std::size_t c = 0; c < 3; ++c) {
    const double* b = data + (6 + 3 * c) * stride + i;
    s[c] += phi * load(data + (3 + c) * stride + i) + gx * load(b) + gy * load(b + stride) +
            gz * load(b + 2 * stride);
  }
}

template <int K, bool hermite>
FOREFEEL_INLINE void sum(std::size_t n, const double* data, std::size_t stride, const double* at, double* f) {
  const Pack y[3] = {same(at[0]), same(at[1]), same(at[2])};
  Pack s[3] = {};
  const auto add = [&](std::size_t i, int turn) __attribute__((always_inline)) {
    if constexpr (hermite)
      add_hermite<K>(data, stride, i, y, turn, s);
    else
      add_plain<K>(data, stride, i, y, turn, s);
  };
  n &= ~std::size_t{7};
  std::size_t i = 0;
  for (; i + 3 * width <= n; i += 3 * width) {
    add(i, 0);
    add(i + width, 1);
    add(i + 2 * width, 2);
  }
  for (; i < n; i += width) add(i, 1);
  for (std::size_t c = 0; c < 3; ++c) f[c] += sum_of(s[c]);
}

template <int K>
FOREFEEL_INLINE void plain_jacobian_of(std::size_t n, const double* data, std::size_t stride,
                                       const double* at, double* f, double* j) {
  const Pack y[3] = {same(at[0]), same(at[1]), same(at[2])};
  Pack s[3] = {}, t[9] = {};
  for (std::size_t i = 0; i < (n & ~std::size_t{7}); i += width) {
    const Distance d = distance(data, stride, i, y, 1);
    const Pack phi = power_of<K>(d.r2, d.r), slope = double(K) * power_of<K - 2>(d.r2, d.r);
    for (std::size_t c = 0; c < 3; ++c) {
      const Pack a = load(data + (3 + c) * stride + i), w = a * slope;
      s[c] += a * phi;
      t[3 * c] += w * d.dx;
      t[3 * c + 1] += w * d.dy;
      t[3 * c + 2] += w * d.dz;
    }
  }
  for (std::size_t c = 0; c < 3; ++c) f[c] += sum_of(s[c]);
  for (std::size_t c = 0; c < 9; ++c) j[c] += sum_of(t[c]);
}

template <int K>
FOREFEEL_INLINE void hermite_jacobian_of(std::size_t n, const double* data, std::size_t stride,
                                         const double* at, double* f, double* j) {
  const Pack y[3] = {same(at[0]), same(at[1]), same(at[2])};
  Pack s[3] = {}, t[9] = {};
  for (std::size_t i = 0; i < (n & ~std::size_t{7}); i += width) {
    const Distance d = distance(data, stride, i, y, 1);
    const Pack low = power_of<K - 2>(d.r2, d.r), lower = double(K - 2) * power_of<K - 4>(d.r2, d.r);
    for (std::size_t c = 0; c < 3; ++c) {
      const double* b = data + (6 + 3 * c) * stride + i;
      const Pack a = load(data + (3 + c) * stride + i), bx = load(b), by = load(b + stride),
                 bz = load(b + 2 * stride);
      const Pack along = bx * d.dx + by * d.dy + bz * d.dz;
      s[c] += low * (a * d.r2 - double(K) * along);
      const Pack radial = double(K) * (a * low - lower * along), step = double(K) * low;
      t[3 * c] += radial * d.dx - step * bx;
      t[3 * c + 1] += radial * d.dy - step * by;
      t[3 * c + 2] += radial * d.dz - step * bz;
    }
  }
  for (std::size_t c = 0; c < 3; ++c) f[c] += sum_of(s[c]);
  for (std::size_t c = 0; c < 9; ++c) j[c] += sum_of(t[c]);
}

void plain(int power, std::size_t n, const double* data, std::size_t stride, const double y[3], double f[3]) {
  if (power == 1) return sum<1, false>(n, data, stride, y, f);
  if (power == 3) return sum<3, false>(n, data, stride, y, f);
  sum<5, false>(n, data, stride, y, f);
}

void hermite(int power, std::size_t n, const double* data, std::size_t stride, const double y[3],
             double f[3]) {
  if (power == 3) return sum<3, true>(n, data, stride, y, f);
  sum<5, true>(n, data, stride, y, f);
}

void plain_jacobian(int power, std::size_t n, const double* data, std::size_t stride, const double y[3],
                    double f[3], double j[9]) {
  if (power == 1) return plain_jacobian_of<1>(n, data, stride, y, f, j);
  if (power == 3) return plain_jacobian_of<3>(n, data, stride, y, f, j);
  plain_jacobian_of<5>(n, data, stride, y, f, j);
}

void hermite_jacobian(int power, std::size_t n, const double* data, std::size_t stride, const double y[3],
                      double f[3], double j[9]) {
  if (power == 3) return hermite_jacobian_of<3>(n, data, stride, y, f, j);
  hermite_jacobian_of<5>(n, data, stride, y, f, j);
}

void supports(std::size_t n, const double* px, const double* py, const double* pz, const double axes[13][3],
              double low[13], double high[13]) {
  const double* __restrict x = px;
  const double* __restrict y = py;
  const double* __restrict z = pz;
  for (int k = 0; k < 13; ++k) {
    const double a = axes[k][0], b = axes[k][1], c = axes[k][2];
    double least = 1e300, most = -1e300;
    for (std::size_t i = 0; i < n; ++i) {
      const double along = a * x[i] + b * y[i] + c * z[i];
      least = along < least ? along : least;
      most = along > most ? along : most;
    }
    low[k] = least;
    high[k] = most;
  }
}

void extent(std::size_t n, const double* __restrict px, const double* __restrict py,
            const double* __restrict pz, const double* __restrict weight, double out[5]) {
  double x = 0, y = 0, z = 0, squares = 0, largest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double w = weight[i], square = w * (px[i] * px[i] + py[i] * py[i] + pz[i] * pz[i]);
    x += w * px[i];
    y += w * py[i];
    z += w * pz[i];
    squares += square;
    largest = square > largest ? square : largest;
  }
  const double all[5] = {x, y, z, squares, largest};
  for (int k = 0; k < 5; ++k) out[k] = all[k];
}

void distances(std::size_t n, const double* __restrict px, const double* __restrict py,
               const double* __restrict pz, const double* __restrict weight, const double y[3],
               double* __restrict distance, double out[2]) {
  const double y0 = y[0], y1 = y[1], y2 = y[2];
  double least = 1e300, most = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double dx = px[i] - y0, dy = py[i] - y1, dz = pz[i] - y2;
    const double r = __builtin_sqrt(dx * dx + dy * dy + dz * dz), counted = weight[i] * r;
    distance[i] = r;
    most = counted > most ? counted : most;
    const double near = weight[i] > 0 ? r : 1e300;
    least = near < least ? near : least;
  }
  out[0] = least;
  out[1] = most;
}

void tangent(std::size_t n, const double* __restrict px, const double* __restrict py,
             const double* __restrict pz, const double* __restrict weight, const double* __restrict data,
             std::size_t stride,
             const double* __restrict distance, double nearest, double farthest, const double base[3],
             double out[19]) {
  const double floor = 1e-6 * farthest + 1e-300, scale = nearest / (farthest + floor);
  Pack sum[19] = {};
  for (std::size_t i = 0; i < n; i += width) {  // arrays have room for a whole vector, of weight 0
    const Pack r = load(distance + i), apart = r > floor ? r : same(floor);
    const Pack share = (farthest / apart - 1.0) * scale;
    const Pack w = load(weight + i) * (share > 0.0 ? share * share : Pack{});
    const Pack d[3] = {load(px + i) - base[0], load(py + i) - base[1], load(pz + i) - base[2]};
    sum[0] += w;
    for (std::size_t c = 0; c < 3; ++c) {
      sum[1 + c] += w * d[c];
      sum[4 + c] += w * load(data + (3 + c) * stride + i);
      Pack along = {};
      for (std::size_t e = 0; e < 3; ++e) {
        const Pack k = w * load(data + (6 + 3 * c + e) * stride + i);
        sum[7 + 3 * c + e] += k;
        along += k * d[e];
      }
      sum[16 + c] += along;
    }
  }
  for (std::size_t k = 0; k < 19; ++k) out[k] = sum_of(sum[k]);
}

}  // namespace

extern const sums::Loops sum_loops;
const sums::Loops sum_loops = {plain,  hermite,   plain_jacobian, hermite_jacobian, supports,
                               extent, distances, tangent};

}  // namespace forefeel::FOREFEEL_ISA
