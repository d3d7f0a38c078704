#pragma once
// An independent integration of m x'' + b x' + k x = F, by many small steps of the midpoint rule a frame.

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "scheduling/motion/loop_limit.hpp"

namespace forefeel::test {

// Whether a free swing of m x'' + b x' + k x = -K x(t_k - late frames), F held over a frame, grows.
inline bool free_swing_grows(const LoopPlant& plant, double stiffness, double frame, std::size_t late = 0) {
  double x = 1e-3, v = 0, first = 0, last = 0;
  std::vector<double> under_way(late, 0.0);
  constexpr int steps = 200, frames = 6000;
  for (int k = 0; k < frames; ++k) {
    double force = -stiffness * x;
    if (late > 0) std::swap(force, under_way[static_cast<std::size_t>(k) % late]);
    (k < frames / 2 ? first : last) = std::max(k < frames / 2 ? first : last, std::abs(x));
    for (int i = 0; i < steps; ++i) {
      const double h = frame / steps, a = (force - plant.stiffness * x - plant.damping * v) / plant.mass;
      const double mid_v = v + 0.5 * h * a, mid_x = x + 0.5 * h * v;
      x += h * mid_v;
      v += h * (force - plant.stiffness * mid_x - plant.damping * mid_v) / plant.mass;
    }
    if (!(std::abs(x) < 1)) return true;
  }
  return last > first;
}

}  // namespace forefeel::test
