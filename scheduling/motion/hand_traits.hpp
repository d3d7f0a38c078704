#pragma once
// Properties that differ between hands, besides the stiffness of the grip (hand_device.hpp).

namespace forefeel {

struct HandTraits {
  double mass = 0.1;           // of hand and device [kg]
  double damping_ratio = 0.7;  // zeta [1]
  // Reaction to a surprise: a force that changes by more than `surprise` beyond what the last 0.1 s explain. After
  // `delay` the stiffness of the grip is multiplied by 1 + stiffening; this decays within `calm`.
  double stiffening = 0;  // 0: no reaction [1]
  double surprise = 0.5;  // [N]
  double delay = 0.1;     // [s]
  double calm = 0.5;      // [s]
  bool drawn = false;     // grip, mass, damping, tremor and reaction are drawn from the seed of the session
};

}  // namespace forefeel
