#pragma once
// Signs of the determinants of a Delaunay triangulation, exact and fast for coordinates on a common grid, as
// those of a lattice of states. If 2^s x is an integer below 2^61 for all coordinates x, differences fit 62
// bits, and
//   orientation    |q-p, r-p, s-p|                                                     189 bits
//   sphere         |p-t, |p-t|^2; q-t, ...; r-t, ...; s-t, ...|                        318 bits
// are sums of products of integers of fixed width. A lattice is cospherical throughout: floating-point
// filters decide little there, and general exact arithmetic costs about 20 times as much.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace forefeel {

namespace detail {

// Two's complement, lowest word first. Overflow is not detected; the widths above exclude it.
template <std::size_t N>
struct WideInteger {
  std::array<std::uint64_t, N> word{};

  bool negative() const { return (word[N - 1] >> 63) != 0; }
  int sign() const {
    if (negative()) return -1;
    for (const std::uint64_t w : word)
      if (w != 0) return 1;
    return 0;
  }
};

__extension__ using Unsigned128 = unsigned __int128;
__extension__ using Signed128 = __int128;

template <std::size_t N>
WideInteger<N> wide(Signed128 value) {
  WideInteger<N> result;
  result.word[0] = static_cast<std::uint64_t>(value);
  result.word[1] = static_cast<std::uint64_t>(value >> 64);
  for (std::size_t i = 2; i < N; ++i) result.word[i] = value < 0 ? ~std::uint64_t{0} : 0;
  return result;
}

template <std::size_t N>
WideInteger<N> operator+(const WideInteger<N>& a, const WideInteger<N>& b) {
  WideInteger<N> result;
  Unsigned128 carry = 0;
  for (std::size_t i = 0; i < N; ++i) {
    carry += static_cast<Unsigned128>(a.word[i]) + b.word[i];
    result.word[i] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
  return result;
}

template <std::size_t N>
WideInteger<N> operator-(const WideInteger<N>& a, const WideInteger<N>& b) {
  WideInteger<N> result;
  std::uint64_t borrow = 0;
  for (std::size_t i = 0; i < N; ++i) {
    const Unsigned128 difference = static_cast<Unsigned128>(a.word[i]) - b.word[i] - borrow;
    result.word[i] = static_cast<std::uint64_t>(difference);
    borrow = static_cast<std::uint64_t>(difference >> 64) & 1;
  }
  return result;
}

template <std::size_t N, std::size_t M>
WideInteger<N + M> operator*(const WideInteger<N>& a, const WideInteger<M>& b) {
  WideInteger<N + M> result;
  for (std::size_t i = 0; i < N; ++i) {
    Unsigned128 carry = 0;
    for (std::size_t j = 0; j < M; ++j) {
      carry += static_cast<Unsigned128>(a.word[i]) * b.word[j] + result.word[i + j];
      result.word[i + j] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    result.word[i + M] = static_cast<std::uint64_t>(carry);
  }
  // Read as unsigned, a negative number is too large by 2^(64 N).
  const auto less_above = [&result](std::size_t from, const auto& other) {
    std::uint64_t borrow = 0;
    for (std::size_t i = from; i < N + M; ++i) {
      const Unsigned128 difference = static_cast<Unsigned128>(result.word[i]) - other.word[i - from] - borrow;
      result.word[i] = static_cast<std::uint64_t>(difference);
      borrow = static_cast<std::uint64_t>(difference >> 64) & 1;
    }
  };
  if (a.negative()) less_above(N, b);
  if (b.negative()) less_above(M, a);
  return result;
}

}  // namespace detail

// 2^s x of some points, for the largest s that keeps all below 2^61. exact() is true if all are integers.
template <std::size_t Points>
class GridPoints {
 public:
  using Difference = std::array<std::int64_t, 3>;

  // coordinates: Points x 3
  explicit GridPoints(const std::array<std::array<double, 3>, Points>& coordinates) {
    std::uint64_t most = 0;  // largest magnitude, as bits: these are in the order of the magnitudes
    for (const auto& point : coordinates)
      for (const double x : point)
        most = std::max(most, std::bit_cast<std::uint64_t>(x) & ~(std::uint64_t{1} << 63));
    const auto exponent = static_cast<std::int64_t>(most >> 52);  // 2^(exponent - 1023) <= |x|
    if (exponent < 200 || exponent > 1083)
      return;  // else scale and products are normal numbers: nothing is rounded
    const double scale =
        std::bit_cast<double>(static_cast<std::uint64_t>(1023 + 60 - (exponent - 1023)) << 52);
    exact_ = true;
    for (std::size_t i = 0; i < Points; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double scaled = coordinates[i][axis] * scale;  // exact: a power of two
        place_[i][axis] = static_cast<std::int64_t>(scaled);
        exact_ = exact_ && static_cast<double>(place_[i][axis]) == scaled;
      }
  }
  bool exact() const { return exact_; }
  Difference operator()(std::size_t i, std::size_t from) const {
    return {place_[i][0] - place_[from][0], place_[i][1] - place_[from][1], place_[i][2] - place_[from][2]};
  }

 private:
  std::array<std::array<std::int64_t, 3>, Points> place_{};
  bool exact_ = false;
};

using GridVector = std::array<std::int64_t, 3>;

namespace detail {

inline Signed128 minor(const GridVector& a, const GridVector& b, std::size_t i, std::size_t j) {
  return static_cast<Signed128>(a[i]) * b[j] - static_cast<Signed128>(a[j]) * b[i];
}

// |a, b, c| from the minors of a and b.
inline WideInteger<3> triple(const std::array<Signed128, 3>& ab, const GridVector& c) {
  const auto term = [](Signed128 m, std::int64_t x) {
    return wide<2>(m) * WideInteger<1>{{static_cast<std::uint64_t>(x)}};
  };
  return term(ab[0], c[0]) + term(ab[1], c[1]) + term(ab[2], c[2]);
}

inline std::array<Signed128, 3> minors(const GridVector& a, const GridVector& b) {
  return {minor(a, b, 1, 2), minor(a, b, 2, 0), minor(a, b, 0, 1)};
}

inline Signed128 squared(const GridVector& a) {
  return static_cast<Signed128>(a[0]) * a[0] + static_cast<Signed128>(a[1]) * a[1] +
         static_cast<Signed128>(a[2]) * a[2];
}

}  // namespace detail

// Sign of |a, b, c|.
inline int orientation_sign(const GridVector& a, const GridVector& b, const GridVector& c) {
  return detail::triple(detail::minors(a, b), c).sign();
}

// Sign of |a, |a|^2; b, |b|^2; c, |c|^2; d, |d|^2| = -|a|^2 |b c d| + |b|^2 |a c d| - |c|^2 |a b d| + |d|^2
// |a b c|.
inline int sphere_sign(const GridVector& a, const GridVector& b, const GridVector& c, const GridVector& d) {
  using namespace detail;
  const std::array<Signed128, 3> ab = minors(a, b), cd = minors(c, d);
  const auto term = [](const GridVector& x, const WideInteger<3>& volume) {
    return volume * wide<2>(squared(x));
  };
  return (term(d, triple(ab, c)) - term(c, triple(ab, d)) + term(b, triple(cd, a)) - term(a, triple(cd, b)))
      .sign();
}

}  // namespace forefeel
