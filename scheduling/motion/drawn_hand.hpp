#pragma once
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

#include <cstdint>

#include "scheduling/motion/device_spec.hpp"

namespace forefeel {

// The hand of this seed; returns `motion` itself unless traits.drawn is set.
HandMotion drawn_hand(const HandMotion& motion, std::uint64_t seed);

}  // namespace forefeel
