#pragma once
// The next state for a model of energy jets: the position whose jet lowers most the estimated errors e_j [1] at the
// points y_j of a sample of the box,
//   gain(x) = sum_j S(e_j) - S(min(e_j, k |y_j - x|^p)),   S(e) = min(log(1 + e / E), 3)
// E: the wanted error; p: order of the jets; k: median of e_j / r_j^p, with r_j the distance of y_j from its nearest
// state. Placing where e is largest instead takes about four times as many states: the largest errors lie at corners,
// where a jet serves few points.

#include <cstddef>
#include <optional>
#include <span>

#include "geometry/coverage/state_space.hpp"

namespace forefeel {

struct CoveringOptions {
  double error = 0.01;  // E [1]
  int order = 4;        // p
};

// The index of a point; those of weight 0 are not chosen, nor known states. nullopt if none is left.
// estimates, weights: of each point.
std::optional<std::size_t> covering_position(const StateSpace& space, std::span<const Vec3> points,
                                             std::span<const double> estimates,
                                             std::span<const double> weights, const CoveringOptions& options);

}  // namespace forefeel
