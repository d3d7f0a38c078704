#pragma once
// A device whose force arrives late: communication or computation delays the loop by n whole frames, d = n T.
//   input.parts.device = make_delayed_device(make_hand_device(profile, target, hand), 0.003, 0.001);
// Drivers and networks delay haptic loops by about 1 to 10 ms; up to 0.1 s is accepted. The delay lowers the stiffness
// that the loop can render (plant and symbols of loop_limit.hpp):
//   exact     all eigenvalues of the map over one frame, with the n forces under way, lie inside the unit circle
//   linear    K < (b + B) / (T / 2 + d), hulin_limit() (Hulin et al. 2006); exact for small K T^2 / m

#include <cstddef>
#include <memory>

#include "scheduling/motion/device.hpp"

namespace forefeel {

// The device with its force delayed by `delay` [s], a whole number of frames of `frame` [s]. limits().stiffness is then
// the exact limit below. InputError for a delay below 0, above 0.1 s, or not of whole frames.
std::unique_ptr<Device> make_delayed_device(std::unique_ptr<Device> device, double delay, double frame);

// The largest stiffness K [N/m] at which the loop with d = frames_late * frame and B = 0 is stable; NaN if mass,
// damping or stiffness is not known. Without delay it equals sampled_limit().
double delayed_limit(const LoopPlant& plant, double frame, std::size_t frames_late);

}  // namespace forefeel
