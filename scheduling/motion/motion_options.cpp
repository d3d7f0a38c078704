#include "scheduling/motion/motion_options.hpp"

namespace forefeel {

void check(const MotionOptions& options) {
  if (!options.replay) check(options.device);
  make_predictor(options.predictor);  // unknown names are refused
}

}  // namespace forefeel
