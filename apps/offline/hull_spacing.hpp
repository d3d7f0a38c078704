#pragma once
// How much of the hull of scattered places is dense, and at which spacing most of it would be.

#include <span>

#include "geometry/coverage/coverage.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

struct HullSpacing {
  double volume = 0;  // of the hull [m^3]
  double spacing =
      unknown;  // at which nine tenths of the hull have a spread of at most safe_spread spacings [m]
};

// Of 2 000 places spread evenly over the box of the states. Whether one lies in the hull, and its spread, are judged by
// its 64 nearest states and the outermost ones in 400 directions: volume and spacing are right within some per cent.
HullSpacing hull_spacing(std::span<const Vec3> states, const Box& box, const CoverageOptions& coverage);

}  // namespace forefeel
