#include "scheduling/session/session_options.hpp"

#include <fmt/format.h>

#include "scheduling/common/option_check.hpp"

namespace forefeel {

using detail::expect_option, detail::positive;

void check(const ClockOptions& o) {
  expect_option(positive(o.seconds) && o.seconds <= 86400, "seconds",
                fmt::format("is {}, expected more than 0 and at most 86400", o.seconds));
  expect_option(positive(o.frame) && o.frame <= 0.1, "frame",
                fmt::format("is {}, expected a frame time above 0 and at most 0.1 s", o.frame));
  expect_option(positive(o.seconds / o.frame) && o.seconds / o.frame < 1e8, "seconds",
                "and frame give too many frames");
}

void check(const SessionOptions& options) {
  check(options.clock);
  check(options.workers);
  check(options.planning);
  check(options.model);
  check(options.judging);
  check(options.safety);
  expect_option(!(options.planning.arrivals && options.motion.replay), "arrivals",
                "cannot go with replay, which brings its own");
  check(options.motion);
}

}  // namespace forefeel
