#pragma once
// A simulated hand that holds a haptic device. It follows a target and yields to the force that is sent:
//   m x'' = k (x_t - x) + b (x_t' - x') + F,   b = 2 zeta sqrt(k m)
// m: effective mass of hand and device [kg], k: stiffness of the grip [N/m], zeta: damping ratio, x_t: target [m],
// F: force sent [N]. Within a frame F is constant and x_t moves on a straight line. The integration is exact for these,
// at any k and m, so it adds no instability to the loop of device, body and one frame of delay. k is constant, except
// during a reaction to a surprise (HandTraits): k then rises from one frame to the next, and b with the square root of
// k, as zeta is constant. Positions are rounded to the profile's resolution, like those of encoders.

#include <memory>

#include "scheduling/motion/device_spec.hpp"

namespace forefeel {

class Device;

struct HandProfile {
  HandName name;
  double force_limit;  // [N]
  double stiffness;    // highest the device can render [N/m]
  double resolution;   // of position [m]
};
// Manufacturers' data: touch (3D Systems Touch, formerly Omni), premium (Premium 1.5), omega (Force Dimension
// omega.3), falcon (Novint).
const HandProfile& profile_of(HandName hand);

struct HandOptions {
  double grip = 300;           // k [N/m]
  double mass = 0.1;           // m [kg]
  double damping_ratio = 0.7;  // zeta
  double stiffening = 0;       // the reaction, as in HandTraits
  double surprise = 0.5;       // [N]
  double delay = 0.1;          // [s]
  double calm = 0.5;           // [s]
};
HandOptions options_of(const HandMotion& motion);

// The target starts at rest, x_t(0) = 0.
std::unique_ptr<Device> make_hand_device(const HandProfile& profile, std::unique_ptr<Device> target,
                                         const HandOptions& options);

}  // namespace forefeel
