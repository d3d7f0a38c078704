#pragma once
// Counter-based random numbers. Each is a function of its key alone: neither the order of draws nor the
// number of threads matters. Mixed by the finaliser of splitmix64 (Steele, Lea, Flood 2014).
//
//   random::uniform(random::mix(seed, i))    // the i-th number of a seed, in (0, 1)

#include <cmath>
#include <cstdint>
#include <cstring>

#include "geometry/common/types.hpp"

namespace forefeel::random {

inline std::uint64_t mix(std::uint64_t z) noexcept {
  z += 0x9e3779b97f4a7c15ull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}
inline std::uint64_t mix(std::uint64_t a, std::uint64_t b) noexcept {
  return mix(mix(a) ^ b);
}

// In (0, 1), never 0 or 1.
inline double uniform(std::uint64_t key) noexcept {
  return (static_cast<double>(mix(key) >> 12) + 0.5) * 0x1p-52;
}

inline constexpr double two_pi = 6.283185307179586476925286766559;

// Standard normal (Box and Muller 1958).
inline double normal(std::uint64_t key) noexcept {
  return std::sqrt(-2 * std::log(uniform(key))) * std::cos(two_pi * uniform(mix(key, 0x5bd1e995)));
}

// Key of a position, rounded to a micrometre: the same place always gives the same draw.
inline std::uint64_t position_key(const Vec3& x) noexcept {
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) key = mix(key, static_cast<std::uint64_t>(std::llround(x[i] * 1e6)));
  return key;
}

}  // namespace forefeel::random
