#pragma once
// Judges the stability of a session whose motion depends on the force, from its frames alone:
//   E_k = E_(k-1) - (F_k + F_(k-1)) . dx_k / 2     energy that the hand has put in [J]
// with F the force sent [N] and dx the step of the measured tip [m]. A body returns at most the energy that it stores.
// So E is limited to |f| |x|, with f the largest force so far [N] (sent, or of the newest model): more than that was
// dissipated. The loop generates energy when E falls below zero (energy observer; Hannaford and Ryu 2002).
// A session is unstable if one of these holds:
//   energy       within a second, D = max(0, -E) grows by more than the quantum of the encoder,
//                  Q = sqrt(3) r / 2 (2 max |F| + sum |dF|)   [J],   r: resolution of each axis [m],
//                the largest effect on E of positions that are wrong by r / 2
//   oscillation  the vibration of the tip grows over three periods: seven extrema of alternating sign, each from the
//                third on at least 5 % larger than the last but one, the last at least 1.5 times the first and above
//                a floor (8 r or 5 times the tremor, whichever is larger). The intervals between them differ by less
//                than a factor of about two
// Vibration: position minus the position smoothed twice over 0.1 s, which leaves frequencies above about 5 Hz. `hold`
// is the energy that holding the force for a frame adds to E, - sum (F_k - F_(k-1)) . dx_k / 2 (K dx^2 / 2 per frame
// for a spring; Colgate and Schenkel 1997). A device with enough damping absorbs it.

#include <array>
#include <optional>
#include <span>

#include "scheduling/common/records.hpp"

namespace forefeel {

// Properties of device and grip; unknown if the device does not report them.
struct HandNumbers {
  double grip = unknown;        // stiffness [N/m]
  double damping = unknown;     // of the grip [N s/m]
  double mass = unknown;        // of hand and device [kg]
  double tremor = 0;            // prescribed motion faster than 5 Hz: tremor and noise, RMS per axis [m]
  double resolution = unknown;  // of positions [m]
  double stiffness = unknown;   // highest the device can render [N/m]
};

struct HandMotion;
HandNumbers hand_numbers(const HandMotion& motion);

struct StabilityReport {
  bool stable = true;
  double since = unknown;             // time of the first instability [s]
  double generated = 0;               // largest growth of D in a second, less its quantum [J]
  double put_in = 0, given_back = 0;  // by the hand, to the hand [J]
  double hold = 0;                    // by forces held for a frame [J]
  ByLabel<double> generated_in{};     // growth of D [J]
  double by_switches = 0,
         by_a_switch = 0;      // work of rendered less newest model: all, the most of one switch [J]
  double frequency = unknown;  // dominant in the second of strongest vibration, if above the floor [Hz]
  double amplitude = 0;        // RMS of the vibration in that second [m]
  double growth = unknown;     // largest growth of an oscillation over three periods, per period [1]
};

// frame: time from frame to frame [s]. The frames of a whole session, in order.
StabilityReport judge_stability(std::span<const FrameRecord> frames, const HandNumbers& hand, double frame);

}  // namespace forefeel
