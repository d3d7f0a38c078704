#include "scheduling/motion/drawn_hand.hpp"

#include <algorithm>
#include <cmath>

#include "scheduling/motion/random.hpp"

namespace forefeel {

HandMotion drawn_hand(const HandMotion& motion, std::uint64_t seed) {
  if (!motion.traits.drawn) return motion;
  constexpr std::uint64_t of_hands = 0x68616e6473ull;  // apart from other draws of the seed
  const auto key = [seed](std::uint64_t i) { return random::mix(random::mix(seed, of_hands), i); };
  const auto between = [&](std::uint64_t i, double low, double high) {
    return low + (high - low) * random::uniform(key(i));
  };
  HandMotion hand = motion;
  hand.grip = std::clamp(motion.grip * std::exp(0.5 * random::normal(key(0))), 100.0, 1000.0);
  hand.traits = {.mass = between(1, 0.1, 0.5),
                 .damping_ratio = between(2, 0.3, 0.8),
                 .stiffening = between(3, 0, 1),
                 .surprise = motion.traits.surprise,
                 .delay = between(4, 0.05, 0.1),
                 .calm = motion.traits.calm};
  hand.target.tremor = std::exp(between(5, std::log(50e-6), std::log(200e-6)));
  return hand;
}

}  // namespace forefeel
