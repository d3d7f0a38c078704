#pragma once
// Interventions of the passivity control of a session (render/passivity.hpp). Not filled if passivity is only observed.

#include <cstddef>

namespace forefeel {

struct PassivityReport {
  bool on = false;
  double coupling = 0;         // K_c: largest stiffness rendered [N/m]; infinite: no limit is known
  std::size_t coupled = 0;     // frames in which the coupling was softer than the body
  std::size_t drained = 0;     // frames in which the tank lowered the force
  std::size_t controlled = 0;  // frames in which the controller damped
  double least_gain = 1;       // least factor s g of coupling and tank together [1]
  double lowest = 0;  // least energy E + q of the tank [J]; below zero: the limits did not allow more damping
  double refused = 0;     // sum over switches of the energy that they would have generated [J]
  double dissipated = 0;  // energy taken by the controller [J]
};

}  // namespace forefeel
