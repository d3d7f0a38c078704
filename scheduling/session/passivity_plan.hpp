#pragma once
// The passivity control of a session, from its options and the limits of its device.
//   K_c = 0.95 min(K_stable, S T / r)
// K_stable [N/m]: boundary of the loop of device and hand (sampled_limit() of motion/loop_limit.hpp) where the device
// tells mass, damping and stiffness, else the highest stiffness that the device says it can render. S [N/s]: slew
// limit, T [s]: frame, r [m]: resolution. Above S T / r one step of the encoder asks for more than the slew limit
// lets through, and the force lags behind.

#include "scheduling/motion/device.hpp"
#include "scheduling/render/passivity.hpp"
#include "scheduling/render/safety.hpp"

namespace forefeel {

// The largest K_c allowed: limits.coupling may ask for less. Infinite where the device says nothing.
double largest_coupling(const SafetyOptions& safety, const DeviceLimits& device, double frame);

// Throws InputError("session.limits.coupling", …) where more is asked for.
PassivityOptions passivity_options(const SafetyOptions& safety, const DeviceLimits& device, double frame);

}  // namespace forefeel
