#pragma once
// Whether a box holds any position of the lattice {k h}^3 (lattice() in state_space.hpp lists them).

#include <cmath>

#include "geometry/common/types.hpp"

namespace forefeel {

// A corner that is a lattice point within rounding belongs to the lattice.
inline bool holds_lattice_position(const Box& box, double spacing) {
  const Eigen::Array3d first = (box.low.array() / spacing - 1e-9).ceil(),
                       last = (box.high.array() / spacing + 1e-9).floor();
  return (first <= last).all();
}

}  // namespace forefeel
