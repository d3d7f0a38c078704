#pragma once
// Where the HIP (haptic interaction point) is, and where it is expected to be.

#include "geometry/common/types.hpp"

namespace forefeel {

struct HipSample {
  double t = 0;                  // [s]
  Vec3 at = Vec3::Zero();        // [m]
  Vec3 velocity = Vec3::Zero();  // [m/s]
  SurfacePlace site = {};  // of the pad, while a body that may be touched anywhere is touched; else none
};

// The expected position `horizon` seconds from now, with its standard deviation per axis.
struct Prediction {
  double horizon = 0;      // [s]
  Vec3 at = Vec3::Zero();  // [m]
  double deviation = 0;    // [m]
};

}  // namespace forefeel
