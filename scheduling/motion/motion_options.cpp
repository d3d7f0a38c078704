#include "scheduling/motion/motion_options.hpp"

#include "scheduling/motion/predictor.hpp"

namespace forefeel {

void check(const MotionOptions& options) {
  make_predictor(options.predictor);  // unknown names are refused
}

}  // namespace forefeel
