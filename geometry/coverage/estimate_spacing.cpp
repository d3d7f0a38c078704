#include "geometry/coverage/estimate_spacing.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include "geometry/common/quantiles.hpp"
#include "geometry/index/point_octree.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_measured = 20'000;

}  // namespace

double estimate_spacing(std::span<const State> states) {
  PointOctree points;
  std::vector<Vec3> positions;
  std::vector<PointOctree::Neighbour> near;
  for (const State& state : states) {
    if (!positions.empty()) points.nearest(state.at, 1, near);
    if (!near.empty() && near[0].squared == 0) continue;
    points.insert(static_cast<std::uint32_t>(positions.size()), state.at);
    positions.push_back(state.at);
  }
  std::vector<double> distance;
  const std::size_t step = 1 + positions.size() / most_measured;
  for (std::size_t i = 0; i < positions.size(); i += step) {
    points.nearest(positions[i], 2, near);
    if (near.size() == 2) distance.push_back(std::sqrt(near[1].squared));
  }
  return median(std::move(distance));
}

}  // namespace forefeel
