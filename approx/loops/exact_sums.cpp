// Compiled once per instruction set.
#include "approx/loops/exact_sums.hpp"

#include "approx/loops/lanes.hpp"

namespace forefeel::FOREFEEL_ISA {
namespace {

// hi + lo, unevaluated: about 32 digits (Dekker 1971).
struct Two {
  Pack hi, lo;
};

FOREFEEL_INLINE Two ordered(Pack a, Pack b) {  // a + b, |a| >= |b|
  const Pack s = a + b;
  return {s, b - (s - a)};
}
FOREFEEL_INLINE Two sum(Pack a, Pack b) {
  const Pack s = a + b, t = s - a;
  return {s, (a - (s - t)) + (b - t)};
}
FOREFEEL_INLINE Two operator+(Two a, Two b) {
  const Two s = sum(a.hi, b.hi);
  return ordered(s.hi, s.lo + (a.lo + b.lo));
}
FOREFEEL_INLINE Two operator*(Two a, Two b) {
  const Pack p = a.hi * b.hi;
  return ordered(p, fused(a.hi, b.hi, -p) + (a.hi * b.lo + a.lo * b.hi));
}
FOREFEEL_INLINE Two operator*(Two a, Pack b) {
  const Pack p = a.hi * b;
  return ordered(p, fused(a.hi, b, -p) + a.lo * b);
}
FOREFEEL_INLINE Two operator-(Two a) {
  return {-a.hi, -a.lo};
}

FOREFEEL_INLINE Two root(Two a) {
  Pack r;
  for (std::size_t i = 0; i < width; ++i) r[i] = __builtin_sqrt(a.hi[i]);
  const Pack p = r * r, rest = ((a.hi - p) - fused(r, r, -p)) + a.lo;
  return ordered(r, r > 0.0 ? rest / (r + r) : Pack{});
}
FOREFEEL_INLINE Two inverse(Two a) {  // 0 for 0
  const Pack q = 1.0 / (a.hi > 0.0 ? a.hi : same(1.0));
  const Pack rest = fused(-q, a.hi, same(1.0)) - q * a.lo;
  const Two r = ordered(q, q * rest);
  return {a.hi > 0.0 ? r.hi : Pack{}, a.hi > 0.0 ? r.lo : Pack{}};
}

// A polynomial component (of 10 x 4) and its gradient at y.
FOREFEEL_INLINE void polynomial_at(const double* p, const Pack y[3], Two& value, Two gradient[3]) {
  constexpr int first[6] = {0, 1, 2, 0, 0, 1}, second[6] = {0, 1, 2, 1, 2, 2};
  value = {same(p[0]), Pack{}};
  for (int d = 0; d < 3; ++d) {
    const Two slope{same(p[4 * (1 + d)]), Pack{}};
    gradient[d] = slope;
    value = value + slope * y[d];
  }
  for (int t = 0; t < 6; ++t) {
    const Two c{same(p[4 * (4 + t)]), Pack{}};
    const Two by_first = c * y[first[t]], by_second = c * y[second[t]];
    value = value + by_first * y[second[t]];
    gradient[first[t]] = gradient[first[t]] + by_second;
    gradient[second[t]] = gradient[second[t]] + by_first;
  }
}

template <int K, bool hermite>
void misfit_of(std::size_t n, const double* data, std::size_t stride, const double* polynomial,
               const double* given, std::size_t given_stride, double* misfit) {
  for (std::size_t i = 0; i < n; i += width) {
    const Pack y[3] = {load(data + i), load(data + stride + i), load(data + 2 * stride + i)};
    Two value[3], gradient[3][3];
    for (int c = 0; c < 3; ++c) polynomial_at(polynomial + c, y, value[c], gradient[c]);
    for (std::size_t j = 0; j < n; ++j) {
      Two d[3];
      for (std::size_t e = 0; e < 3; ++e) d[e] = sum(y[e], -same(data[e * stride + j]));
      const Two r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2], r = root(r2);
      const Two low = K == 1 ? r : K == 3 ? r : r * r2;  // phi = low r^2, for K = 1: low
      const Two phi = K == 1 ? low : low * r2;
      if constexpr (!hermite) {
        for (std::size_t c = 0; c < 3; ++c) value[c] = value[c] + phi * same(data[(3 + c) * stride + j]);
      } else {
        const Two lower = K == 3 ? inverse(r) : r * same(3.0);  // (K - 2) r^(K - 4)
        const Two step = low * same(double(K));
        for (std::size_t c = 0; c < 3; ++c) {
          const double* b = data + (6 + 3 * c) * stride + j;
          const Pack a = same(data[(3 + c) * stride + j]);
          const Two along = d[0] * same(b[0]) + d[1] * same(b[stride]) + d[2] * same(b[2 * stride]);
          value[c] = value[c] + phi * a + -(step * along);
          const Two radial = (low * a + -(lower * along)) * same(double(K));
          for (std::size_t e = 0; e < 3; ++e)
            gradient[c][e] = gradient[c][e] + radial * d[e] + -(step * same(b[e * stride]));
        }
      }
    }
    const auto left = [&](std::size_t array, Two model) __attribute__((always_inline)) {
      const Two rest = Two{load(given + array * given_stride + i), Pack{}} + -model;
      store(misfit + array * given_stride + i, rest.hi);
    };
    for (std::size_t c = 0; c < 3; ++c) {
      left(c, value[c]);
      if constexpr (hermite)
        for (std::size_t e = 0; e < 3; ++e) left(3 + 3 * c + e, gradient[c][e]);
    }
  }
}

void misfit(int power, bool hermite, std::size_t n, const double* data, std::size_t stride,
            const double* polynomial, const double* given, std::size_t given_stride, double* out) {
  if (hermite) {
    if (power == 3) return misfit_of<3, true>(n, data, stride, polynomial, given, given_stride, out);
    return misfit_of<5, true>(n, data, stride, polynomial, given, given_stride, out);
  }
  if (power == 1) return misfit_of<1, false>(n, data, stride, polynomial, given, given_stride, out);
  if (power == 3) return misfit_of<3, false>(n, data, stride, polynomial, given, given_stride, out);
  misfit_of<5, false>(n, data, stride, polynomial, given, given_stride, out);
}

}  // namespace

extern const exact::Loops exact_loops;
const exact::Loops exact_loops = {misfit};

}  // namespace forefeel::FOREFEEL_ISA
