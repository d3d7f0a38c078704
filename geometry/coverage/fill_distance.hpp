#pragma once
// The fill distance: sup over a box of the distance delta to the nearest state. By branch and bound: delta is
// 1-Lipschitz, so over a part of the box with centre c and half-diagonal e it lies between delta(c) and
// delta(c) + e.

#include <cstddef>
#include <functional>

#include "geometry/common/types.hpp"

namespace forefeel {

struct FillDistance {
  double reached = 0;  // largest delta that was found [m]
  double bound = 0;    // no place of the box is farther from its nearest state [m]
};

// delta: distance to the nearest state [m]. known: a value that delta is known to reach [m]; parts where delta is below
// it are skipped. Stops when bound - reached <= tolerance [m], or after `budget` evaluations of delta.
FillDistance largest_distance(const std::function<double(const Vec3&)>& delta, const Box& box, double known,
                              double tolerance, std::size_t budget);

// The largest delta at the corners and on the faces of a box, and `known`, if that is larger [m].
double largest_in_box(const std::function<double(const Vec3&)>& delta, const Box& box, double known,
                      double tolerance);

}  // namespace forefeel
