#pragma once
// Where the hand goes and how its way is foretold.

#include <filesystem>
#include <optional>

#include "scheduling/motion/device_spec.hpp"
#include "scheduling/motion/predictor.hpp"

namespace forefeel {

struct MotionOptions {
  DeviceSpec device = {};  // path:press,speed=0.06
  PredictorSpec predictor = "kalman";
  // The folder of a run whose motion and arrivals are repeated; `device` is ignored then.
  std::optional<std::filesystem::path> replay = {};
};

// InputError names the key of a value that cannot be used.
void check(const MotionOptions& options);

}  // namespace forefeel
