#pragma once
// Where the hand goes and how its way is foretold.

#include <filesystem>
#include <optional>
#include <string>

namespace forefeel {

struct MotionOptions {
  std::string device = "path:press,speed=0.06";  // device.hpp
  std::string predictor = "kalman";              // predictor.hpp
  // The folder of a run whose motion and arrivals are repeated; `device` is ignored then.
  std::optional<std::filesystem::path> replay = {};
};

// InputError names the key of a value that cannot be used.
void check(const MotionOptions& options);

}  // namespace forefeel
