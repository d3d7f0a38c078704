#pragma once
// The points of a box at which a placement estimates its error. Private to this room.

#include <cstddef>
#include <vector>

#include "geometry/common/halton.hpp"
#include "geometry/common/types.hpp"

namespace forefeel {

// First a uniform sample of the box, for quantiles; then a grid up to its faces.
struct EstimatePoints {
  std::vector<Vec3> at;
  std::size_t uniform = 0;

  explicit EstimatePoints(const Box& box) {
    constexpr double grid_shares[] = {-1, -0.75, -0.4, 0, 0.4, 0.75, 1};
    constexpr std::size_t uniform_points = 512;
    at = halton_points(box, uniform_points);
    uniform = at.size();
    const Vec3 centre = box.centre(), half = 0.5 * box.size();
    for (const double x : grid_shares)
      for (const double y : grid_shares)
        for (const double z : grid_shares) at.push_back(centre + half.cwiseProduct(Vec3(x, y, z)));
  }
};

}  // namespace forefeel
