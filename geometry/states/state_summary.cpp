#include "geometry/states/state_summary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "geometry/states/energy_jet.hpp"
#include "geometry/states/state_outcome.hpp"

namespace forefeel {
StateSetSummary summarise(std::span<const State> states) {
  StateSetSummary sum;
  sum.states = states.size();
  if (!states.empty()) sum.extent = {states.front().at, states.front().at};
  for (const State& s : states) {
    sum.extent.low = sum.extent.low.cwiseMin(s.at), sum.extent.high = sum.extent.high.cwiseMax(s.at);
    ++sum.by_status[std::string(name(outcome(s)))];
    sum.multivalued += s.solve.multivalued;
    sum.inverted += has_inverted_elements(s);
    if (std::isfinite(s.solve.seconds)) sum.solve_seconds += s.solve.seconds;
    if (!s.usable()) continue;
    ++sum.usable;
    sum.with_stiffness += s.has_stiffness();
    sum.with_energy += std::isfinite(s.energy);
    sum.with_displacements += s.displacements != nullptr;
    sum.with_jet += s.jet != nullptr;
    sum.max_force = std::max(sum.max_force, s.force.norm());
  }
  sum.at_one_position = repeated_states(states);
  return sum;
}

double typical_distance(std::span<const State> states) {
  const std::size_t count = std::min<std::size_t>(states.size(), 200);
  std::vector<double> distances(count, std::numeric_limits<double>::infinity());
  std::array<std::vector<double>, 3>
      at;  // apart from the other values of the states: they are read `count` times
  for (Eigen::Index a = 0; a < 3; ++a)
    for (const State& state : states) at[static_cast<std::size_t>(a)].push_back(state.at[a]);
#pragma omp parallel for schedule(dynamic, 4)
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3& from = states[k * states.size() / count].at;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < states.size(); ++i) {
      const double x = at[0][i] - from.x(), y = at[1][i] - from.y(), z = at[2][i] - from.z();
      const double squared = x * x + y * y + z * z;
      least = squared > 0 && squared < least ? squared : least;
    }
    distances[k] = std::sqrt(least);
  }
  if (distances.empty()) return std::numeric_limits<double>::infinity();
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

}  // namespace forefeel
