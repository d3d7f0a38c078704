#pragma once
// The types of numbers in binary files.

#include <array>
#include <cstddef>
#include <cstdint>

namespace forefeel {

enum class Scalar : std::uint8_t {
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64
};

constexpr std::size_t bytes_of(Scalar type) {
  constexpr std::array<std::size_t, 10> sizes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

// action(T{}) with the C++ type of these numbers.
template <class Action>
void with_type(Scalar type, Action&& action) {
  switch (type) {
    case Scalar::int8:
      return action(std::int8_t{});
    case Scalar::uint8:
      return action(std::uint8_t{});
    case Scalar::int16:
      return action(std::int16_t{});
    case Scalar::uint16:
      return action(std::uint16_t{});
    case Scalar::int32:
      return action(std::int32_t{});
    case Scalar::uint32:
      return action(std::uint32_t{});
    case Scalar::int64:
      return action(std::int64_t{});
    case Scalar::uint64:
      return action(std::uint64_t{});
    case Scalar::float32:
      return action(float{});
    case Scalar::float64:
      return action(double{});
  }
}

}  // namespace forefeel
