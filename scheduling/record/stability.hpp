#pragma once
// Verdict on the stability of a session whose motion answers the force. From the frames alone:
//   E_k = E_(k-1) - (F_k + F_(k-1)) . dx_k / 2     energy that the hand has put in [J]
// with F the force sent [N] and dx the step of the measured tip [m]. A body returns at most what it stores:
// where E exceeds |f| |x|, f the largest model force so far, the rest was dissipated and is dropped from E. The
// loop generates energy where E falls below zero (energy observer; Hannaford and Ryu 2002, Eq. 4).
//   unstable   if over some second D = max(0, -E) grows by more than the encoder's quantum of that second,
//                Q = sqrt(3) r / 2 (2 max |F| + sum |dF|),   r resolution of each axis [m],
//              which bounds what positions that are off by r / 2 do to E; or
//              if what motion does not explain swings up over three periods: seven extrema of alternating
//              sign, each pair larger than the one before by 5 % or more, all of like length, at least 1.5 times
//              in all, to more than `floor`.
// What motion does not explain: position less itself smoothed twice over 0.1 s, which leaves what is faster
// than some 5 Hz. `hold` is the energy that a force held for a frame adds to E, - sum (F_k - F_(k-1)) . dx_k / 2
// (K dx^2 / 2 per frame of a spring; Colgate and Schenkel 1997): a device with enough damping absorbs it.

#include <array>
#include <optional>
#include <span>

#include "scheduling/log/records.hpp"

namespace forefeel {

// Device and grip as numbers; unknown where the device does not say.
struct HandNumbers {
  double grip = unknown;        // stiffness [N/m]
  double damping = unknown;     // of the grip [N s/m]
  double mass = unknown;        // of hand and device [kg]
  double tremor = 0;            // meant motion that is faster than 5 Hz: tremor and noise, RMS per axis [m]
  double resolution = unknown;  // of positions [m]
  double stiffness = unknown;   // highest the device can render [N/m]
};

struct StabilityReport {
  bool stable = true;
  double since = unknown;                // first moment that is not [s]
  double generated = 0;                  // most in any second, beyond the quantum of that second [J]
  double put_in = 0, given_back = 0;     // by the hand, to the hand [J]
  double hold = 0;                       // by forces held for a frame [J]
  std::array<double, 4> generated_in{};  // growth of D by label [J], in the order of Label
  double by_switches = 0,
         by_a_switch = 0;      // work of rendered less newest model: all, the most of one switch [J]
  double frequency = unknown;  // dominant in the strongest second, where above `floor` [Hz]
  double amplitude = 0;        // RMS of what motion does not explain in that second [m]
  double growth = unknown;     // of the strongest swing over three periods, per period [1]
};

// frame: time from frame to frame [s]. The frames of a whole session, in order.
StabilityReport judge_stability(std::span<const FrameRecord> frames, const HandNumbers& hand, double frame);

}  // namespace forefeel
