#pragma once
// The options of a session that a report needs to evaluate its frames.

#include <algorithm>
#include <cmath>

#include "geometry/common/types.hpp"
#include "scheduling/common/records.hpp"
#include "scheduling/record/felt_steps.hpp"

namespace forefeel {

struct RunView {
  Box box = {};                  // where states are placed [m]
  double spacing = 0.006;        // [m]
  double force_limit = unknown;  // largest force that is sent [N]
  double jnd_share = 0.07;       // just noticeable difference: max(jnd_share |F|, jnd_floor)
  double jnd_floor = 0.010;      // [N]
  FeltRule felt = {};            // which steps of the force a hand feels
  double error_floor = 0.05;     // errors are relative to max(|reference|, error_floor) [N]
};

// Error of a frame in just noticeable differences; NaN where it was not compared.
inline double times_jnd(const FrameRecord& frame, const RunView& view) {
  const double reference = frame.judged.reference.norm();
  return frame.judged.error * std::max(reference, view.error_floor) /
         std::max(view.jnd_share * reference, view.jnd_floor);
}

}  // namespace forefeel
