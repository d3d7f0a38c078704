#include "apps/study_speed.hpp"

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
  double failed = 0;  // the lowest speed above found.speed that did not hold; 0: none yet
  int failures = 0;
  for (double speed = options.low; failures < 2; speed = std::min(2 * speed, options.high)) {
    if (holds(speed)) {
      found.speed = speed;
      failed = 0;
      failures = 0;
    } else {
      failed = failed > 0 ? failed : speed;
      ++failures;
    }
    if (speed >= options.high) break;
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
