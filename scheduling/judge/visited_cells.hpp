#pragma once
// Detects first visits of lattice cells: cubes of side h whose corners lie in a box.

#include <cmath>
#include <set>
#include <tuple>

#include "geometry/common/types.hpp"

namespace forefeel {

class VisitedCells {
 public:
  VisitedCells(const Box& box, double side)  // [m]; the margin keeps faces: 6 x 0.006 > 0.036 in doubles
      : box_{box.low.array() - 1e-9 * side, box.high.array() + 1e-9 * side}, side_(side) {}

  // Whether `at` is the first position in its cell; marks the cell as visited.
  bool first(const Vec3& at) {
    const Vec3 cell = (at / side_).array().floor();
    if (!box_.contains(side_ * cell) || !box_.contains(side_ * (cell + Vec3::Ones()))) return false;
    return cells_.insert({std::lround(cell[0]), std::lround(cell[1]), std::lround(cell[2])}).second;
  }
  std::size_t count() const { return cells_.size(); }

 private:
  Box box_;
  double side_;
  std::set<std::tuple<long, long, long>> cells_;
};

}  // namespace forefeel
