#pragma once
// The states that a motion needs: the corners of the lattice cells it visits, inside the box and not known at
// the start.

#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include "geometry/common/types.hpp"

namespace forefeel {

class NeededStates {
 public:
  NeededStates(const Box& box, double spacing)  // [m]; the margin keeps faces: 6 x 0.006 > 0.036 in doubles
      : box_{box.low.array() - 1e-9 * spacing, box.high.array() + 1e-9 * spacing}, spacing_(spacing) {}

  void know(const Vec3& at) {  // known at the start; ignored off the lattice
    const Vec3 step = (at / spacing_).array().round();
    if ((at - spacing_ * step).norm() < 1e-6 * spacing_) known_.insert(place(step));
  }
  void visit(const Vec3& at) {
    const Vec3 cell = (at / spacing_).array().floor();
    if (cell == last_) return;
    last_ = cell;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 step = cell.array() + Eigen::Array3d(corner & 1, (corner >> 1) & 1, corner >> 2);
      if (box_.contains(spacing_ * step) && !known_.contains(place(step))) corners_.insert(place(step));
    }
  }
  std::size_t count() const { return corners_.size(); }

 private:
  using Place = std::tuple<long, long, long>;
  static Place place(const Vec3& step) {
    return {std::lround(step[0]), std::lround(step[1]), std::lround(step[2])};
  }

  Box box_;
  double spacing_;
  Vec3 last_ = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  std::set<Place> corners_, known_;
};

}  // namespace forefeel
