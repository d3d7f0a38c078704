#pragma once
// The motion of the hand, and the predictor that extrapolates it.

#include <filesystem>
#include <optional>

#include "scheduling/motion/device_spec.hpp"
#include "scheduling/motion/predictor.hpp"

namespace forefeel {

struct MotionOptions {
  DeviceSpec device = {};  // path:press,speed=0.06
  PredictorSpec predictor = "kalman";
  // Folder of an earlier run. Its motion and arrivals are repeated, and `device` is ignored.
  std::optional<std::filesystem::path> replay = {};
};

// Throws InputError with the key of an invalid value.
void check(const MotionOptions& options);

}  // namespace forefeel
