#include "geometry/index/morton_order.hpp"

#include <omp.h>

#include <algorithm>
#include <parallel/algorithm>
#include <utility>

namespace forefeel {

std::vector<std::uint32_t> morton_order(std::span<const State> states, const Box& box, double spacing) {
  std::vector<Vec3> at;
  at.reserve(states.size());
  for (const State& state : states) at.push_back(state.at);
  return morton_order(at, box, spacing);
}

namespace {

constexpr std::size_t many = 100'000;  // positions whose order all threads find

// The lowest 21 bits, two zeros between each and the next.
std::uint64_t spread_bits(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x001f00000000ffff;
  bits = (bits | bits << 16) & 0x001f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  return (bits | bits << 2) & 0x1249249249249249;
}

}  // namespace

std::vector<std::uint32_t> morton_order(std::span<const Vec3> at, const Box& box, double spacing) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> code(at.size());
  std::vector<std::uint32_t> order(at.size());
  const bool together = at.size() >= many && !omp_in_parallel();
#pragma omp parallel for schedule(static) if (together)
  for (std::uint32_t i = 0; i < at.size(); ++i) {
    std::uint64_t value = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double cell = std::clamp((at[i][axis] - box.low[axis]) / spacing + 0.5, 0.0, 2097151.0);
      value |= spread_bits(static_cast<std::uint64_t>(cell)) << axis;
    }
    code[i] = {value, i};
  }
  if (together)
    __gnu_parallel::sort(code.begin(), code.end());
  else
    std::sort(code.begin(), code.end());
#pragma omp parallel for schedule(static) if (together)
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = code[i].second;
  return order;
}

}  // namespace forefeel
