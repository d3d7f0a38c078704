#include "geometry/states/repeated_states.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace forefeel {

bool contradict(const State& a, const State& b) {
  return a.usable() && b.usable() &&
         (a.force - b.force).norm() > 1e-6 * std::max(a.force.norm(), b.force.norm());
}

RepeatedStates repeated_states(std::span<const State> states) {
  std::vector<std::size_t> order(states.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto position = [&](std::size_t i) {
    return std::array{states[i].at.x(), states[i].at.y(), states[i].at.z()};
  };
  std::ranges::stable_sort(order, {}, position);
  RepeatedStates found;
  const State *before = nullptr, *usable = nullptr;  // the last state at a position, and its first usable one
  for (const std::size_t i : order) {
    const State& state = states[i];
    if (before != nullptr && before->at == state.at)
      ++found.repeated;
    else
      usable = nullptr;
    if (usable == nullptr)
      usable = state.usable() ? &state : nullptr;
    else if (contradict(*usable, state))
      ++found.contradicting;
    before = &state;
  }
  return found;
}

}  // namespace forefeel
