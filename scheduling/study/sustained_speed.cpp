#include "scheduling/study/sustained_speed.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {

SustainedSpeed sustained_speed(const SustainedOptions& options,
                               const std::function<double(double)>& share_at) {
  SustainedSpeed found;
  const auto holds = [&](double speed) {
    ++found.trials;
    return share_at(speed) >= options.share;
  };
  double failed = 0;  // the lowest speed above found.speed that did not hold; 0: none
  for (double speed = options.high;; speed = std::max(0.5 * speed, options.low)) {
    if (holds(speed)) {
      found.speed = speed;
      break;
    }
    failed = speed;
    if (speed <= options.low) break;
  }
  found.capped = found.speed >= options.high;
  if (found.speed == 0 || found.capped) return found;
  while (failed > 1.05 * found.speed) {
    const double middle = std::sqrt(found.speed * failed);
    (holds(middle) ? found.speed : failed) = middle;
  }
  return found;
}

}  // namespace forefeel
