#include "scheduling/placement/covering.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "geometry/common/quantiles.hpp"

namespace forefeel {

std::optional<std::size_t> covering_position(const StateSpace& space, std::span<const Vec3> points,
                                             std::span<const double> estimates,
                                             std::span<const double> weights,
                                             const CoveringOptions& options) {
  constexpr double most = 3;  // of S
  const auto share = [&](double e) { return std::min(std::log1p(e / options.error), most); };
  std::vector<double> growth, now;
  std::vector<StateId> nearest;
  for (std::size_t j = 0; j < points.size(); ++j) {
    now.push_back(share(estimates[j]));
    space.nearest(points[j], 1, nearest);
    if (nearest.empty()) continue;
    const double r = (space[nearest[0]].at - points[j]).norm();
    if (r > 0) growth.push_back(estimates[j] / std::pow(r, options.order));
  }
  if (growth.empty()) return {};
  const double half_order = 0.5 * options.order, k = median(std::move(growth));
  std::optional<std::size_t> best;
  double largest = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(weights[i] > 0) || space.find(points[i]).valid()) continue;
    double gain = 0;
    for (std::size_t j = 0; j < points.size(); ++j) {
      const double after = k * std::pow((points[j] - points[i]).squaredNorm(), half_order);
      if (after < estimates[j]) gain += now[j] - share(after);
    }
    gain *= weights[i];
    if (!best || gain > largest) {
      best = i;
      largest = gain;
    }
  }
  return best;
}

}  // namespace forefeel
