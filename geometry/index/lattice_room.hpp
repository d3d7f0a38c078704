#pragma once
// Does a box hold any position of the lattice {k h}^3? lattice() in coverage/state_space.hpp lists them.

#include <cmath>

#include "geometry/common/types.hpp"

namespace forefeel {

// spacing: h [m]. Lattice points on the boundary of the box count, within rounding.
inline bool holds_lattice_position(const Box& box, double spacing) {
  const Eigen::Array3d first = (box.low.array() / spacing - 1e-9).ceil(),
                       last = (box.high.array() / spacing + 1e-9).floor();
  return (first <= last).all();
}

}  // namespace forefeel
