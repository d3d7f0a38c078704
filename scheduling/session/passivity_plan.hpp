#pragma once
// The options of passivity control, from the options of a session and the limits of its device.
//   K_c = 0.95 min(K_stable, S T / r)     [N/m]
// K_stable [N/m]: stability limit of the loop of device and hand (sampled_limit() of motion/loop_limit.hpp) if the
// device gives mass, damping and stiffness, else the highest stiffness that the device can render. S [N/s]: slew limit,
// T [s]: time of a frame, r [m]: resolution of the device. Above S T / r, one step of the encoder changes the force by
// more than the slew limit allows, and the force sent lags behind.
//
// The price. Where the body's stiffness K is above K_c, the force sent is K_c / K of the rendered one. Nothing else is
// lost. Example: a liver phantom of 150 and 500 kPa (K = 10.1 and 33.8 kN/m at rest), omega.3 in a light grip, K_c =
// 8.5 kN/m. Control changed the force by 16 and 75 %, which is 1 - K_c / K to three digits; the tank did not lower the
// force further. This is a limit of the device. K_stable is the exact boundary of the loop. Colgate's bound 2 b / T
// lies within 1 % below it for these plants, and a sweep of gains finds the boundary between 0.75 and 1.15 K_c / 0.95
// (tests/scheduling/test_passivity.cpp). Only the margin of 5 % is a choice. More stiffness needs more damping b,
// shorter frames T, or a virtual damper, which helps one known hand but lowers the bound for all others (Colgate and
// Schenkel 1997).

#include "scheduling/motion/device.hpp"
#include "scheduling/render/passivity.hpp"
#include "scheduling/render/safety.hpp"

namespace forefeel {

// The largest K_c allowed; limits.coupling may ask for less. Infinite if the device gives no limit.
double largest_coupling(const SafetyOptions& safety, const DeviceLimits& device, double frame);

// Throws InputError("session.limits.coupling", …) if limits.coupling asks for more.
PassivityOptions passivity_options(const SafetyOptions& safety, const DeviceLimits& device, double frame);

}  // namespace forefeel
