#pragma once
// sup over a box of the distance delta to the nearest state, by branch and bound: delta is 1-Lipschitz, so over a part
// of the box with centre c and half-diagonal e it lies between delta(c) and delta(c) + e.

#include <cstddef>
#include <functional>

#include "geometry/common/types.hpp"

namespace forefeel {

struct FillDistance {
  double reached = 0;  // delta at some place of the box [m]
  double bound = 0;    // no place of the box is farther from a state [m]
};

// delta: distance to the nearest state [m]. known: a value that delta is known to reach; parts below it are not looked
// at. Stops when the bound is within the tolerance [m] of what is reached, or after `budget` places.
FillDistance largest_distance(const std::function<double(const Vec3&)>& delta, const Box& box, double known,
                              double tolerance, std::size_t budget);

}  // namespace forefeel
