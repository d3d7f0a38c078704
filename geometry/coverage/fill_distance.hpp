#pragma once
// The fill distance: sup over a box of the distance delta to the nearest state. By branch and bound: delta is
// 1-Lipschitz, so over a part of the box with centre c and half-diagonal e it lies between delta(c) and
// delta(c) + e.

#include <functional>
#include <vector>

#include "geometry/coverage/region_summary.hpp"
#include "geometry/index/delaunay_index.hpp"

namespace forefeel {

// The largest delta in the box, at most `tolerance` too small [m]. delta: distance to the nearest state [m]. known: a
// value that delta is known to reach [m]; parts where delta is below it are skipped.
double largest_distance(const std::function<double(const Vec3&)>& delta, const Box& box, double known,
                        double tolerance);

// The largest delta at the corners and on the faces of a box, and `known`, if that is larger [m].
double largest_in_box(const std::function<double(const Vec3&)>& delta, const Box& box, double known,
                      double tolerance);

// The balls of the Delaunay cells that are not flat, with their centres in the box: delta has its maxima there, or on
// the faces of the box.
std::vector<EmptyBall> empty_balls(const DelaunayIndex& delaunay, const Box& box);
inline bool smaller(const EmptyBall& a, const EmptyBall& b) {
  return a.radius < b.radius;
}

}  // namespace forefeel
