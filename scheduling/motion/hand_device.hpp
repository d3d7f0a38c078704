#pragma once
// A simulated hand that holds a haptic device. It follows a target and yields to the force that is sent:
//   m x'' = k (x_t - x) + b (x_t' - x') + F,   b = 2 zeta sqrt(k m)
// m: effective mass of hand and device [kg], k: stiffness of the grip [N/m], zeta: damping ratio, x_t: target [m],
// F: force sent [N]. Within a frame F is constant and x_t moves on a straight line. The integration is exact for these,
// at any k and m, so it adds no instability to the loop of device, body and one frame of delay. k is constant, except
// during a reaction to a surprise (HandTraits): k then rises from one frame to the next, and b with the square root of
// k, as zeta is constant. Positions are rounded to the profile's resolution, like those of encoders.

#include <cstdint>
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

// A hand drawn from a seed: each seed is a different simulated person. Where HandMotion::traits.drawn is set:
//   k     grip [N/m]           log-normal about the grip asked for (300), sigma 0.5, cut to 100 to 1000
//   zeta  damping ratio [1]    uniform, 0.3 to 0.8
//   m     mass [kg]            uniform, 0.1 to 0.5, of hand and device
//   tremor RMS per axis [m]    log-uniform, 50 to 200 um at 8 to 12 Hz, in place of that of the target
//   delay of the reaction [s]  uniform, 0.05 to 0.1
//   stiffening [1]             uniform, 0 to 1
// Each of them is a function of the seed alone. Sources of the ranges: an arm measured through a haptic device had
// 0.55 kg, 6.5 N s/m and 135 N/m in one typical trial, zeta = 0.37 (van Beek et al., Sci. Rep. 5:18004, 2015). Hands on
// a knob become stiffer and more damped with the force of the grip (Hasser and Cutkosky, HAPTICS 2002).
// The long-latency response of the arm to a perturbation comes 50 to 100 ms after it
// (doi 10.1371/journal.pone.0163854). How far the grip then stiffens, and the widths of the other ranges, are
// assumptions: as wide as the grips light, medium and firm are apart.

// The hand of this seed; returns `motion` itself unless traits.drawn is set.
HandMotion drawn_hand(const HandMotion& motion, std::uint64_t seed);

}  // namespace forefeel
