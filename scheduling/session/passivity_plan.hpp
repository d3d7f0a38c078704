#pragma once
// The options of passivity control, from the options of a session and the limits of its device.
//   K_c = 0.95 min(K_stable, S T / r)     [N/m]
// K_stable [N/m]: stability limit of the loop of device and hand (sampled_limit() of motion/loop_limit.hpp) if the
// device gives mass, damping and stiffness, else the highest stiffness that the device can render. S [N/s]: slew limit,
// T [s]: time of a frame, r [m]: resolution of the device. Above S T / r, one step of the encoder changes the force by
// more than the slew limit allows, and the force sent lags behind.

#include "scheduling/motion/device.hpp"
#include "scheduling/render/passivity.hpp"
#include "scheduling/render/safety.hpp"

namespace forefeel {

// The largest K_c allowed; limits.coupling may ask for less. Infinite if the device gives no limit.
double largest_coupling(const SafetyOptions& safety, const DeviceLimits& device, double frame);

// Throws InputError("session.limits.coupling", …) if limits.coupling asks for more.
PassivityOptions passivity_options(const SafetyOptions& safety, const DeviceLimits& device, double frame);

}  // namespace forefeel
