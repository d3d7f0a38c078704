#include "scheduling/session/passivity_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scheduling/common/option_check.hpp"

namespace forefeel {

double largest_coupling(const SafetyOptions& safety, const DeviceLimits& device, double frame) {
  constexpr double margin = 0.95;
  const double boundary = sampled_limit(device.plant, frame);
  double limit = std::isnan(boundary) ? device.stiffness : boundary;
  if (device.plant.resolution > 0)
    limit = std::min(limit, safety.slew_limit * frame / device.plant.resolution);
  return margin * limit;
}

PassivityOptions passivity_options(const SafetyOptions& safety, const DeviceLimits& device, double frame) {
  const double most = largest_coupling(safety, device, frame), asked = safety.coupling.value_or(most);
  if (safety.passivity == Passivity::control)
    detail::expect_option(
        asked <= most, "limits.coupling",
        fmt::format("is {:g} N/m, expected at most {:.4g}: above it the loop of this device, its "
                    "hand and frames of {:g} s is not stable",
                    asked, most, frame));
  return {.mode = safety.passivity,
          .coupling = asked,
          .resolution = device.plant.resolution,
          .force_limit = std::min(safety.force_limit, device.force)};
}

}  // namespace forefeel
