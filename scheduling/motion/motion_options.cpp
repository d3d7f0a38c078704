#include "scheduling/motion/motion_options.hpp"

namespace forefeel {

void check(const MotionOptions& options) {
  if (!options.replay) check(options.device);
  // Unknown names are refused; settings may name files that only a session finds.
  if (options.predictor.settings.empty()) make_predictor(options.predictor);
}

}  // namespace forefeel
