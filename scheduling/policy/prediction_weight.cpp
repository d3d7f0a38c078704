#include "scheduling/policy/prediction_weight.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {

double urgency(double t, double solve) {
  const double late = (solve - t) / solve;
  return late > 0 ? 1 / (1 + late * late) : 1 / (1 - late);
}

double sureness(double deviation, double h) {
  return 1 / (1 + std::pow(deviation / (2 * h), 2));
}

Vec3 folded(const Vec3& x, const Box& box) {
  Vec3 inside = box.low;
  for (int i = 0; i < 3; ++i) {
    const double size = box.high[i] - box.low[i];
    if (!(size > 0) || !std::isfinite(x[i])) continue;
    const double place = std::fmod(std::abs(x[i] - box.low[i]), 2 * size);
    inside[i] += std::min(place, 2 * size - place);
  }
  return inside;
}

}  // namespace forefeel
