#pragma once
// A simulated hand that holds a haptic device: it wants to follow a target and yields to the force it is given,
//   m x'' = k (x_t - x) + b (x_t' - x') + F,   b = 2 zeta sqrt(k m)
// m effective mass of hand and device [kg], k stiffness of the grip [N/m], x_t target [m], F rendered force [N]. Between
// frames F is held and x_t is a straight line, for which the step is exact at any k and m; so the loop of device, body
// and one frame's delay is as stable or unstable as the sampled system is, not as an integrator makes it.
// Positions come in steps of the profile's resolution, as encoders give them.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scheduling/motion/device.hpp"

namespace forefeel {

struct HandProfile {
  const char* name;
  double force_limit;  // [N]
  double stiffness;    // highest that the device renders [N/m]
  double resolution;   // of position [m]
};
// Makers' data: touch (3D Systems Touch, formerly Omni), premium (Premium 1.5), omega (Force Dimension omega.3), falcon
// (Novint). Null for other names.
const HandProfile* find_hand_profile(const std::string& name);
std::vector<std::string> hand_profile_names();

struct HandOptions {
  double grip = 300;           // k [N/m]
  double mass = 0.1;           // m [kg]
  double damping_ratio = 0.7;  // zeta
};

// The target starts at rest, x_t(0) = 0.
std::unique_ptr<Device> make_hand_device(const HandProfile& profile, std::unique_ptr<Device> target,
                                         const HandOptions& options);

}  // namespace forefeel
