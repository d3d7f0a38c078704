#include "apps/offline/hull_spacing.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/common/halton.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/index/local_spread.hpp"
#include "geometry/index/point_octree.hpp"

namespace forefeel {
namespace {

constexpr std::size_t hull_places = 2000, hull_near = 64, hull_directions = 400;

// The states farthest out, in directions spread evenly over the sphere.
std::vector<Vec3> outermost(std::span<const Vec3> states, const PointOctree& index) {
  std::vector<Vec3> found;
  for (const Vec3& share : halton_points({Vec3::Zero(), Vec3::Ones()}, hull_directions)) {
    const double turn = 2 * M_PI * share.x(), z = 2 * share.y() - 1, across = std::sqrt(1 - z * z);
    found.push_back(states[index.farthest({across * std::cos(turn), across * std::sin(turn), z})]);
  }
  return found;
}

}  // namespace

HullSpacing hull_spacing(std::span<const Vec3> states, const Box& box, const CoverageOptions& coverage) {
  HullSpacing result;
  if (states.size() < 4 || !(box.size().minCoeff() > 0)) return result;
  const PointOctree index(states);
  const std::vector<Vec3> rim = outermost(states, index), places = halton_points(box, hull_places);
  std::vector<double> spreads(places.size());
#pragma omp parallel for schedule(dynamic, 16)
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Vec3& q = places[i];
    thread_local std::vector<PointOctree::Neighbour> near;
    std::vector<Vec3> offsets;
    index.nearest(q, hull_near, near);
    for (const PointOctree::Neighbour& n : near) offsets.push_back(states[n.id] - q);
    LocalSpread cell = least_spread(offsets, std::sqrt(near.back().squared));
    if (!std::isfinite(cell.spread)) {
      for (const Vec3& at : rim) offsets.push_back(at - q);
      cell = least_spread(offsets, box.size().maxCoeff());
    }
    spreads[i] = cell.spread;
  }
  std::erase_if(spreads, [](double spread) { return !std::isfinite(spread); });
  result.volume = box.size().prod() * double(spreads.size()) / double(hull_places);
  if (!spreads.empty()) result.spacing = quantile_of(std::move(spreads), 0.9) / coverage.safe_spread;
  return result;
}

}  // namespace forefeel
