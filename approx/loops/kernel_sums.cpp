// Compiled once per instruction set, with -ffast-math: sums over centres, whose order of addition is free.
#include "approx/loops/kernel_sums.hpp"

#include <bit>
#include <cstdint>
#include <limits>

#include "approx/loops/lanes.hpp"
#include "approx/loops/point_sums.hpp"

namespace forefeel::FOREFEEL_ISA {
namespace {

// `tiny` is added to r^2, so that 1 / r is finite (in single precision if it is estimated there). The divider
// works in parallel with the other units: of each turn, the first `estimated` vectors take their roots by
// estimates, the others from the divider.
#if defined(__AVX512F__)
constexpr double tiny = 1e-200;
constexpr std::size_t turn = 3, estimated = 2;
constexpr bool hermite_divided = false;
#elif defined(__AVX2__)
constexpr double tiny = 1e-37;
constexpr std::size_t turn = 5, estimated = 2;
constexpr bool hermite_divided = true;
#else
constexpr double tiny = 1e-200;
constexpr std::size_t turn = 1, estimated = 0;
constexpr bool hermite_divided = true;
#endif

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

// g sqrt(x) / g for an estimate g of sqrt(x) and e = 1 - g^2 / x: the series of (1 - e)^(-1/2).
[[maybe_unused]] FOREFEEL_INLINE Pack refined(Pack g, Pack e) {
#if defined(__AVX512F__)
  const Pack series = times_plus(same(0.3125), e, same(0.375));
#else
  const Pack series = times_plus(times_plus(same(0.2734375), e, same(0.3125)), e, same(0.375));
#endif
  return times_plus(g * e, times_plus(series, e, same(0.5)), g);
}

#if defined(__AVX512F__)
FOREFEEL_INLINE Pack inverse_root_estimate(Pack x) {
  return reinterpret_cast<Pack>(_mm512_rsqrt14_pd(reinterpret_cast<__m512d>(x)));
}
// Keeps x as it is: -ffast-math must not rearrange the product that it belongs to.
FOREFEEL_INLINE Pack kept(Pack x) {
  asm("" : "+v"(x));
  return x;
}
#endif

// sqrt(x), x >= tiny, to an ulp: from the divider, or from the processor's estimate of 1 / sqrt(x) and a
// series. The estimate of AVX-512 is within 2^-14 (series to e^3), that of single precision within 1.5 2^-12
// (series to e^4).
FOREFEEL_INLINE Pack root(Pack x, [[maybe_unused]] bool divided) {
#if defined(__AVX512F__)
  if (!divided) {
    const Pack y = inverse_root_estimate(x), g = x * y;
    return refined(g, times_plus(-g, y, same(1)));
  }
#elif defined(__AVX2__)
  if (!divided) {
    const __m128 narrow = _mm_rsqrt_ps(_mm256_cvtpd_ps(reinterpret_cast<__m256d>(x)));
    const Pack y = reinterpret_cast<Pack>(_mm256_cvtps_pd(narrow)), g = x * y;
    return refined(g, times_plus(-g, y, same(1)));
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
                                  bool divided) {
  Distance d;
  d.dx = y[0] - load(data + i);
  d.dy = y[1] - load(data + stride + i);
  d.dz = y[2] - load(data + 2 * stride + i);
  d.r2 = times_plus(d.dz, d.dz, times_plus(d.dy, d.dy, times_plus(d.dx, d.dx, same(tiny))));
  d.r = root(d.r2, divided);
  return d;
}

template <int K>
FOREFEEL_INLINE void add_plain(const double* data, std::size_t stride, std::size_t i, const Pack y[3],
                               bool divided, Pack s[3]) {
  const Distance d = distance(data, stride, i, y, divided);
  const Pack phi = power_of<K>(d.r2, d.r);
  for (std::size_t c = 0; c < 3; ++c) s[c] = times_plus(phi, load(data + (3 + c) * stride + i), s[c]);
}

// Six sums as named members: GCC would keep an array on the stack between two loops.
struct HermiteSums {
  Pack s0{}, s1{}, s2{}, t0{}, t1{}, t2{};
};

template <int K>
FOREFEEL_INLINE void add_hermite(const double* data, std::size_t stride, std::size_t i, const Pack y[3],
                                 HermiteSums& sums) {
  const Distance d = distance(data, stride, i, y, hermite_divided);
  const Pack low = power_of<K - 2>(d.r2, d.r);  // phi = low r^2
  const Pack phi = low * d.r2, slope = -double(K) * low;
  const Pack gx = slope * d.dx, gy = slope * d.dy, gz = slope * d.dz;
  const auto add = [&](std::size_t c, Pack & s, Pack & t) __attribute__((always_inline)) {
    const double* b = data + (6 + 3 * c) * stride + i;
    s = times_plus(phi, load(data + (3 + c) * stride + i), times_plus(gx, load(b), s));
    t = times_plus(gy, load(b + stride), times_plus(gz, load(b + 2 * stride), t));
  };
  add(0, sums.s0, sums.t0);
  add(1, sums.s1, sums.t1);
  add(2, sums.s2, sums.t2);
}

// A polynomial (10 x 4, see kernel_sums.hpp), quadratic for r^5 alone, and its gradient; p(t) is the t-th
// coefficient of one component or of all.
template <int K, class Coefficient, class Value>
FOREFEEL_INLINE auto value_of(const Coefficient& p, const Value* y) {
  if constexpr (K < 5) return (p(0) + y[0] * p(1)) + (y[1] * p(2) + y[2] * p(3));
  if constexpr (K == 5)
    return (p(0) + y[0] * (p(1) + y[0] * p(4) + y[1] * p(7) + y[2] * p(8))) +
           (y[1] * (p(2) + y[1] * p(5) + y[2] * p(9)) + y[2] * (p(3) + y[2] * p(6)));
}
template <int K, class Coefficient>
FOREFEEL_INLINE double slope_of(const Coefficient& p, const double* y, int d) {
  constexpr int cross[3][2] = {{7, 8}, {7, 9}, {8, 9}}, other[3][2] = {{1, 2}, {0, 2}, {0, 1}};
  if constexpr (K < 5) return p(1 + d);
  return p(1 + d) + 2 * y[d] * p(4 + d) + y[other[d][0]] * p(cross[d][0]) + y[other[d][1]] * p(cross[d][1]);
}

// The sums of three vectors and the polynomial.
template <int K>
FOREFEEL_INLINE void finish(const Pack s[4], const double* p, const Pack y[3], double* f) {
#if defined(__AVX2__)
  const Four at[3] = {first_four(y[0]), first_four(y[1]), first_four(y[2])};
  const auto all_of = [&](int t) __attribute__((always_inline)) {
    return load_quad(p + 4 * t);
  };
  const Four all = sums_of(s) + value_of<K>(all_of, at);
  for (int c = 0; c < 3; ++c) f[c] = all[c];
#else
  const double at[3] = {y[0][0], y[1][0], y[2][0]};
  for (int c = 0; c < 3; ++c) {
    const auto one_of = [&](int t) __attribute__((always_inline)) {
      return p[4 * t + c];
    };
    f[c] = sum_of(s[c]) + value_of<K>(one_of, at);
  }
#endif
}
template <int K>
FOREFEEL_INLINE void finish(const Pack s[4], const Pack t[9], const double* p, const Pack y[3], double* f,
                            double* j) {
  finish<K>(s, p, y, f);
  const double at[3] = {y[0][0], y[1][0], y[2][0]};
  for (int c = 0; c < 3; ++c) {
    const auto one_of = [&](int k) __attribute__((always_inline)) {
      return p[4 * k + c];
    };
    for (int d = 0; d < 3; ++d) j[3 * c + d] = sum_of(t[3 * c + d]) + slope_of<K>(one_of, at, d);
  }
}

#if defined(__AVX512F__)
// G vectors of centres in step with each other, so that few instructions wait for the one before; the last D
// take their roots from the divider. phi = h + h e (1/2 + 3/8 e + 5/16 e^2), h = x^(K/2) by the estimated
// root.
template <int K, std::size_t G, std::size_t D>
FOREFEEL_INLINE void add_together(const double* data, std::size_t stride, std::size_t i, const Pack y[3],
                                  Pack s[3]) {
  constexpr std::size_t E = G - D;
  Pack r2[G], phi[G], e[G], series[G];
  for (std::size_t d = 0; d < 3; ++d)
    for (std::size_t t = 0; t < G; ++t) {
      const Pack apart = y[d] - load(data + d * stride + i + t * width);
      r2[t] = times_plus(apart, apart, d == 0 ? same(tiny) : r2[t]);
    }
  for (std::size_t t = 0; t < E; ++t) e[t] = inverse_root_estimate(r2[t]);
  for (std::size_t t = E; t < G; ++t) phi[t] = power_of<K>(r2[t], divided_root(r2[t]));
  for (std::size_t t = 0; t < E; ++t) phi[t] = r2[t] * e[t];
  for (std::size_t t = 0; t < E; ++t) e[t] = times_plus(-phi[t], e[t], same(1));
  for (std::size_t t = 0; t < E; ++t) {
    series[t] = times_plus(same(0.3125), e[t], same(0.375));
    phi[t] = kept(power_of<K>(r2[t], phi[t]));
  }
  for (std::size_t t = 0; t < E; ++t) {
    series[t] = times_plus(series[t], e[t], same(0.5));
    e[t] = kept(e[t] * phi[t]);
  }
  for (std::size_t t = 0; t < E; ++t) phi[t] = times_plus(e[t], series[t], phi[t]);
  for (std::size_t t = 0; t < G; ++t)
    for (std::size_t c = 0; c < 3; ++c)
      s[c] = times_plus(phi[t], load(data + (3 + c) * stride + i + t * width), s[c]);
}

// Sums in groups of four vectors. The remainder comes first, so that nothing waits for its slow roots at the end.
template <int K>
FOREFEEL_INLINE void add_all_plain(std::size_t n, const double* data, std::size_t stride, const Pack y[3],
                                   Pack s[3]) {
  n &= ~std::size_t{7};
  const std::size_t odd = n % (4 * width);
  if (odd == width) add_together<K, 1, 1>(data, stride, 0, y, s);
  if (odd == 2 * width) add_together<K, 2, 0>(data, stride, 0, y, s);
  if (odd == 3 * width) add_together<K, 3, 1>(data, stride, 0, y, s);
  for (std::size_t i = odd; i < n; i += 4 * width) add_together<K, 4, 1>(data, stride, i, y, s);
}
#endif

template <int K>
FOREFEEL_INLINE void add_all_hermite(std::size_t n, const double* data, std::size_t stride, const Pack y[3],
                                     Pack s[3]) {
  HermiteSums sums;
  n &= ~std::size_t{7};
  for (std::size_t i = 0; i < n; i += width) add_hermite<K>(data, stride, i, y, sums);
  s[0] = sums.s0 + sums.t0;
  s[1] = sums.s1 + sums.t1;
  s[2] = sums.s2 + sums.t2;
}

template <int K, bool hermite>
FOREFEEL_INLINE void add_all(std::size_t n, const double* data, std::size_t stride, const Pack y[3],
                             Pack s[3]) {
  if constexpr (hermite) return add_all_hermite<K>(n, data, stride, y, s);
#if defined(__AVX512F__)
  return add_all_plain<K>(n, data, stride, y, s);
#endif
  n &= ~std::size_t{7};
  std::size_t i = 0;
  for (; i + turn * width <= n; i += turn * width)
    for (std::size_t k = 0; k < turn; ++k) add_plain<K>(data, stride, i + k * width, y, k >= estimated, s);
  for (; i < n; i += width) add_plain<K>(data, stride, i, y, 2 * estimated < turn, s);
}

template <int K, bool hermite>
FOREFEEL_INLINE void sum(std::size_t n, const double* data, std::size_t stride, const double* polynomial,
                         const double* at, double* f) {
  const Pack y[3] = {same(at[0]), same(at[1]), same(at[2])};
  Pack s[4] = {};
  add_all<K, hermite>(n, data, stride, y, s);
  finish<K>(s, polynomial, y, f);
}

// |a| <= b; false if a is not a number. Compares bits, because -ffast-math assumes that all values are
// numbers.
[[maybe_unused]] FOREFEEL_INLINE bool not_above(double a, double b) {
  const auto size = std::bit_cast<std::int64_t>(a) & std::numeric_limits<std::int64_t>::max();
  return size <= std::bit_cast<std::int64_t>(b);
}

// The processor overlaps consecutive evaluations by only a few vectors of centres. So few instructions precede the
// first vector, and the polynomial is computed where the sums have to wait anyway.
template <int K, bool hermite>
bool quick(const sums::Sum& m, const double x[3], double f[3]) {
  Pack y[3];
  for (std::size_t d = 0; d < 3; ++d) y[d] = (same(x[d]) - same(m.centre[d])) * same(m.inverse_scale);
  const Pack squared = times_plus(y[0], y[0], times_plus(y[1], y[1], y[2] * y[2]));
  if (!not_above(squared[0], m.limit[3])) return false;
  Pack s[4] = {};
#if defined(__AVX2__)
  const Four at[3] = {first_four(y[0]), first_four(y[1]), first_four(y[2])};
  const auto all_of = [&](int t) __attribute__((always_inline)) {
    return load_quad(m.polynomial + 4 * t);
  };
  Four polynomial = value_of<K>(all_of, at);
  asm("" : "+x"(polynomial));
  add_all<K, hermite>(m.n, m.data, m.stride, y, s);
  const auto all = reinterpret_cast<__m256d>(sums_of(s) + polynomial);
  _mm_storeu_pd(f, _mm256_castpd256_pd128(all));
  _mm_store_sd(f + 2, _mm256_extractf128_pd(all, 1));
  asm("" : "+m"(*reinterpret_cast<double(*)[3]>(f)));
#else
  add_all<K, hermite>(m.n, m.data, m.stride, y, s);
  finish<K>(s, m.polynomial, y, f);
#endif
  return not_above(f[0], m.limit[0]) && not_above(f[1], m.limit[1]) && not_above(f[2], m.limit[2]);
}

template <int K>
FOREFEEL_INLINE void plain_jacobian_of(std::size_t n, const double* data, std::size_t stride,
                                       const double* polynomial, const double* at, double* f, double* j) {
  const Pack y[3] = {same(at[0]), same(at[1]), same(at[2])};
  Pack s[4] = {}, t[9] = {};
  for (std::size_t i = 0; i < (n & ~std::size_t{7}); i += width) {
    const Distance d = distance(data, stride, i, y, estimated == 0);
    const Pack phi = power_of<K>(d.r2, d.r), slope = double(K) * power_of<K - 2>(d.r2, d.r);
    for (std::size_t c = 0; c < 3; ++c) {
      const Pack a = load(data + (3 + c) * stride + i), w = a * slope;
      s[c] += a * phi;
      t[3 * c] += w * d.dx;
      t[3 * c + 1] += w * d.dy;
      t[3 * c + 2] += w * d.dz;
    }
  }
  finish<K>(s, t, polynomial, y, f, j);
}

template <int K>
FOREFEEL_INLINE void hermite_jacobian_of(std::size_t n, const double* data, std::size_t stride,
                                         const double* polynomial, const double* at, double* f, double* j) {
  const Pack y[3] = {same(at[0]), same(at[1]), same(at[2])};
  Pack s[4] = {}, t[9] = {};
  for (std::size_t i = 0; i < (n & ~std::size_t{7}); i += width) {
    const Distance d = distance(data, stride, i, y, hermite_divided);
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
  finish<K>(s, t, polynomial, y, f, j);
}

void plain(int power, std::size_t n, const double* data, std::size_t stride, const double* polynomial,
           const double y[3], double f[3]) {
  if (power == 1) return sum<1, false>(n, data, stride, polynomial, y, f);
  if (power == 3) return sum<3, false>(n, data, stride, polynomial, y, f);
  sum<5, false>(n, data, stride, polynomial, y, f);
}

void hermite(int power, std::size_t n, const double* data, std::size_t stride, const double* polynomial,
             const double y[3], double f[3]) {
  if (power == 3) return sum<3, true>(n, data, stride, polynomial, y, f);
  sum<5, true>(n, data, stride, polynomial, y, f);
}

void plain_jacobian(int power, std::size_t n, const double* data, std::size_t stride,
                    const double* polynomial, const double y[3], double f[3], double j[9]) {
  if (power == 1) return plain_jacobian_of<1>(n, data, stride, polynomial, y, f, j);
  if (power == 3) return plain_jacobian_of<3>(n, data, stride, polynomial, y, f, j);
  plain_jacobian_of<5>(n, data, stride, polynomial, y, f, j);
}

void hermite_jacobian(int power, std::size_t n, const double* data, std::size_t stride,
                      const double* polynomial, const double y[3], double f[3], double j[9]) {
  if (power == 3) return hermite_jacobian_of<3>(n, data, stride, polynomial, y, f, j);
  hermite_jacobian_of<5>(n, data, stride, polynomial, y, f, j);
}

}  // namespace

extern const sums::Loops sum_loops;
const sums::Loops sum_loops = {
    {{quick<1, false>, quick<3, false>, quick<5, false>}, {nullptr, quick<3, true>, quick<5, true>}},
    plain,
    hermite,
    plain_jacobian,
    hermite_jacobian,
    supports,
    extent,
    distances,
    tangent};

}  // namespace forefeel::FOREFEEL_ISA
