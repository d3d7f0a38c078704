#pragma once
// Eight doubles side by side, and what the kernels do with them: minimum, broadcast, logarithm, load, store.
//
// Everything is in an unnamed namespace on purpose: the kernels are compiled once per instruction set, and
// the linker must not pick a function compiled for a newer one for general use. Include in kernel files only.

#include "geometry/common/simd.hpp"
#include "solver/kernels/kernels.hpp"

namespace forefeel {
namespace {

using Lanes = double __attribute__((vector_size(64)));
using LaneBits = long long __attribute__((vector_size(64)));

FOREFEEL_INLINE double least(double a, double b) {
  return b < a ? b : a;
}
FOREFEEL_INLINE Lanes least(Lanes a, Lanes b) {
  return b < a ? b : a;
}
template <class T>
FOREFEEL_INLINE T spread(double value) {
  return value - T{};
}

FOREFEEL_INLINE double logarithm(double x) {
  return __builtin_log(x);
}

// ln x for eight positive normal numbers, within 2 ulp: x = 2^k m, m in [sqrt(1/2), sqrt(2)),
// ln m = 2 artanh s = 2 s (1 + s^2/3 + s^4/5 + ...), s = (m - 1)/(m + 1), |s| < 0.1716: twelve terms suffice.
FOREFEEL_INLINE Lanes logarithm(Lanes x) {
  const long long one = 0x3ff0000000000000LL, root_half = 0x3fe6a09e667f3bcdLL;
  LaneBits bits;
  __builtin_memcpy(&bits, &x, sizeof bits);
  const LaneBits shifted = bits + (one - root_half);
  const LaneBits exponent = (shifted >> 52) - 1023;
  const LaneBits mantissa = (shifted & 0x000fffffffffffffLL) + root_half;
  Lanes m;
  __builtin_memcpy(&m, &mantissa, sizeof m);
  // exponent to floating point: added to the bits of 1.5 * 2^52
  const LaneBits biased = exponent + 0x4338000000000000LL;
  Lanes k;
  __builtin_memcpy(&k, &biased, sizeof k);
  k -= 6755399441055744.0;
  const Lanes f = m - 1.0;
  const Lanes s = f / (f + 2.0), z = s * s;
  Lanes p = z * (1.0 / 23) + 1.0 / 21;
  p = p * z + 1.0 / 19;
  p = p * z + 1.0 / 17;
  p = p * z + 1.0 / 15;
  p = p * z + 1.0 / 13;
  p = p * z + 1.0 / 11;
  p = p * z + 1.0 / 9;
  p = p * z + 1.0 / 7;
  p = p * z + 1.0 / 5;
  p = p * z + 1.0 / 3;
  const Lanes log_m = s * 2.0 + (s * 2.0) * z * p;
  return k * 0.69314718055994530942 + log_m;
}

FOREFEEL_INLINE Lanes load(const double* p) {
  Lanes v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}
FOREFEEL_INLINE void store(double* p, Lanes v) {
  __builtin_memcpy(p, &v, sizeof v);
}

}  // namespace
}  // namespace forefeel
