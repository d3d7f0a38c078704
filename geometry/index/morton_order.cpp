#include "geometry/index/morton_order.hpp"

#include <algorithm>
#include <utility>

namespace forefeel {

std::vector<std::uint32_t> morton_order(std::span<const State> states, const Box& box, double spacing) {
  std::vector<Vec3> at;
  at.reserve(states.size());
  for (const State& state : states) at.push_back(state.at);
  return morton_order(at, box, spacing);
}

std::vector<std::uint32_t> morton_order(std::span<const Vec3> at, const Box& box, double spacing) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> code(at.size());
  for (std::uint32_t i = 0; i < at.size(); ++i) {
    std::uint64_t value = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double cell = std::clamp((at[i][axis] - box.low[axis]) / spacing + 0.5, 0.0, 2097151.0);
      auto bits = static_cast<std::uint64_t>(cell);
      for (int b = 0; b < 21; ++b) value |= (bits >> b & 1) << (3 * b + axis);
    }
    code[i] = {value, i};
  }
  std::sort(code.begin(), code.end());
  std::vector<std::uint32_t> order(at.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = code[i].second;
  return order;
}

}  // namespace forefeel
