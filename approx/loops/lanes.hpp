#pragma once
// Pack: a vector as wide as those of the instruction set that the file is compiled for. Only for loops that are
// compiled once per set. Everything here is local to the file, because the linker must not share it between sets.

#include <cstddef>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "geometry/common/simd.hpp"

namespace forefeel::FOREFEEL_ISA {
namespace {

#if defined(__AVX512F__)
constexpr std::size_t width = 8;
typedef double Pack __attribute__((vector_size(64)));
typedef double Loose __attribute__((vector_size(64), aligned(8), may_alias));
typedef long long Lanes __attribute__((vector_size(64)));
constexpr Lanes lane = {0, 1, 2, 3, 4, 5, 6, 7};
#elif defined(__AVX2__)
constexpr std::size_t width = 4;
typedef double Pack __attribute__((vector_size(32)));
typedef double Loose __attribute__((vector_size(32), aligned(8), may_alias));
typedef long long Lanes __attribute__((vector_size(32)));
constexpr Lanes lane = {0, 1, 2, 3};
#else
constexpr std::size_t width = 2;
typedef double Pack __attribute__((vector_size(16)));
typedef double Loose __attribute__((vector_size(16), aligned(8), may_alias));
typedef long long Lanes __attribute__((vector_size(16)));
constexpr Lanes lane = {0, 1};
#endif

FOREFEEL_INLINE Pack load(const double* at) {
  return *reinterpret_cast<const Loose*>(at);
}
FOREFEEL_INLINE void store(double* at, Pack value) {
  *reinterpret_cast<Loose*>(at) = value;
}
// Stores the lanes from `first` on.
FOREFEEL_INLINE void store_from(double* at, Pack value, std::size_t first) {
#if defined(__AVX512F__)
  _mm512_mask_storeu_pd(at, static_cast<__mmask8>(0xffu << first), reinterpret_cast<__m512d>(value));
#else
  store(at, lane >= static_cast<long long>(first) ? value : load(at));
#endif
}
FOREFEEL_INLINE Pack same(double value) {
  return Pack{} + value;
}
// a b + c, rounded once.
FOREFEEL_INLINE Pack fused(Pack a, Pack b, Pack c) {
#if defined(__AVX512F__)
  return reinterpret_cast<Pack>(_mm512_fmadd_pd(reinterpret_cast<__m512d>(a), reinterpret_cast<__m512d>(b),
                                                reinterpret_cast<__m512d>(c)));
#elif defined(__AVX2__)
  return reinterpret_cast<Pack>(_mm256_fmadd_pd(reinterpret_cast<__m256d>(a), reinterpret_cast<__m256d>(b),
                                                reinterpret_cast<__m256d>(c)));
#else
  for (std::size_t i = 0; i < width; ++i) c[i] = __builtin_fma(a[i], b[i], c[i]);
  return c;
#endif
}
// a b + c where the intermediate rounding does not matter: fused only if that is one instruction.
FOREFEEL_INLINE Pack times_plus(Pack a, Pack b, Pack c) {
#if defined(__AVX2__)
  return fused(a, b, c);
#else
  return a * b + c;
#endif
}
FOREFEEL_INLINE double sum_of(Pack p) {
#if defined(__AVX512F__)
  return ((p[0] + p[4]) + (p[1] + p[5])) + ((p[2] + p[6]) + (p[3] + p[7]));
#elif defined(__AVX2__)
  return (p[0] + p[1]) + (p[2] + p[3]);
#else
  return p[0] + p[1];
#endif
}

// The first four of a vector of eight, zeros after them.
FOREFEEL_INLINE Pack load_four(const double* at) {
#if defined(__AVX512F__)
  return reinterpret_cast<Pack>(_mm512_zextpd256_pd512(_mm256_loadu_pd(at)));
#else
  return load(at);
#endif
}

FOREFEEL_INLINE void move_four(double* to, const double* from) {
#if defined(__AVX2__)
  _mm256_storeu_pd(to, _mm256_loadu_pd(from));
#else
  for (int t = 0; t < 4; t += 2) store(to + t, load(from + t));
#endif
}

// Transposes the square matrix whose rows are in x.
FOREFEEL_INLINE void transpose(Pack x[width]) {
#if defined(__AVX512F__)
  __m512d pair[8], quad[8];
  for (int t = 0; t < 8; t += 2) {
    const auto a = reinterpret_cast<__m512d>(x[t]), b = reinterpret_cast<__m512d>(x[t + 1]);
    pair[t] = _mm512_unpacklo_pd(a, b);      // even columns of rows t, t + 1
    pair[t + 1] = _mm512_unpackhi_pd(a, b);  // odd
  }
  for (int odd = 0; odd < 2; ++odd)
    for (int t = 0; t < 2; ++t) {  // rows 4 t to 4 t + 3: columns 0, 4 and 2, 6 (odd: one more)
      quad[4 * odd + t] = _mm512_shuffle_f64x2(pair[4 * t + odd], pair[4 * t + 2 + odd], 0x88);
      quad[4 * odd + 2 + t] = _mm512_shuffle_f64x2(pair[4 * t + odd], pair[4 * t + 2 + odd], 0xdd);
    }
  for (int odd = 0; odd < 2; ++odd)
    for (int t = 0; t < 2; ++t) {
      const __m512d a = quad[4 * odd + 2 * t], b = quad[4 * odd + 2 * t + 1];
      x[odd + 2 * t] = reinterpret_cast<Pack>(_mm512_shuffle_f64x2(a, b, 0x88));
      x[odd + 2 * t + 4] = reinterpret_cast<Pack>(_mm512_shuffle_f64x2(a, b, 0xdd));
    }
#elif defined(__AVX2__)
  __m256d pair[4];
  for (int t = 0; t < 4; t += 2) {
    const auto a = reinterpret_cast<__m256d>(x[t]), b = reinterpret_cast<__m256d>(x[t + 1]);
    pair[t] = _mm256_unpacklo_pd(a, b);
    pair[t + 1] = _mm256_unpackhi_pd(a, b);
  }
  for (int odd = 0; odd < 2; ++odd) {
    x[odd] = reinterpret_cast<Pack>(_mm256_permute2f128_pd(pair[odd], pair[2 + odd], 0x20));
    x[odd + 2] = reinterpret_cast<Pack>(_mm256_permute2f128_pd(pair[odd], pair[2 + odd], 0x31));
  }
#else
  const Pack a = x[0];
  x[0] = Pack{a[0], x[1][0]};
  x[1] = Pack{a[1], x[1][1]};
#endif
}

#if defined(__AVX2__)
typedef double Four __attribute__((vector_size(32)));

FOREFEEL_INLINE Four load_quad(const double* at) {
  return reinterpret_cast<Four>(_mm256_loadu_pd(at));
}

FOREFEEL_INLINE Four first_four(Pack p) {
#if defined(__AVX512F__)
  return reinterpret_cast<Four>(_mm512_castpd512_pd256(reinterpret_cast<__m512d>(p)));
#else
  return p;
#endif
}

// The sums of four vectors.
FOREFEEL_INLINE Four sums_of(const Pack p[4]) {
#if defined(__AVX512F__)
  __m256d half[2];
  for (int t = 0; t < 2; ++t) {
    const auto a = reinterpret_cast<__m512d>(p[2 * t]), b = reinterpret_cast<__m512d>(p[2 * t + 1]);
    const __m512d pairs = _mm512_add_pd(_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
    half[t] = _mm256_add_pd(_mm512_castpd512_pd256(pairs), _mm512_extractf64x4_pd(pairs, 1));
  }
#else
  const __m256d half[2] = {_mm256_hadd_pd(reinterpret_cast<__m256d>(p[0]), reinterpret_cast<__m256d>(p[1])),
                           _mm256_hadd_pd(reinterpret_cast<__m256d>(p[2]), reinterpret_cast<__m256d>(p[3]))};
#endif
  return reinterpret_cast<Four>(_mm256_add_pd(_mm256_permute2f128_pd(half[0], half[1], 0x20),
                                              _mm256_permute2f128_pd(half[0], half[1], 0x31)));
}
#endif
FOREFEEL_INLINE void sums_of(const Pack p[4], double out[4]) {
#if defined(__AVX2__)
  _mm256_storeu_pd(out, reinterpret_cast<__m256d>(sums_of(p)));
#else
  for (int t = 0; t < 4; ++t) out[t] = sum_of(p[t]);
#endif
}

// Writes four values by one store, so that a following load of all four does not stall.
FOREFEEL_INLINE void store_four(double* at, double a, double b, double c, double d) {
#if defined(__AVX2__)
  _mm256_storeu_pd(at, _mm256_set_pd(d, c, b, a));
#else
  at[0] = a;
  at[1] = b;
  at[2] = c;
  at[3] = d;
#endif
}

}  // namespace
}  // namespace forefeel::FOREFEEL_ISA
