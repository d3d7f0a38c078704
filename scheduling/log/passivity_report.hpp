#pragma once
// What the passivity control of a session did (render/passivity.hpp). All zero where it only observes.

#include <cstddef>

namespace forefeel {

struct PassivityReport {
  bool on = false;
  double coupling = 0;         // K_c: largest stiffness rendered [N/m]; infinite: no limit is known
  std::size_t coupled = 0;     // frames in which the coupling was softer than the body
  std::size_t drained = 0;     // frames in which the tank held force back
  std::size_t controlled = 0;  // frames in which the controller damped
  double least_gain = 1;       // of coupling and tank together
  double lowest = 0;      // least energy in the tank, dead zone included [J]; below zero: could not be held
  double refused = 0;     // sum over switches of what they would have generated [J]
  double dissipated = 0;  // by the controller [J]
};

}  // namespace forefeel
