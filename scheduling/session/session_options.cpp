#include "scheduling/session/session_options.hpp"

#include <fmt/format.h>

#include <cmath>

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

namespace {

void check_switch(const SwitchOptions& o) {
  expect_option(std::isfinite(o.jnd_share) && o.jnd_share >= 0 && o.jnd_share <= 1, "switching.jnd_share",
                fmt::format("is {}, expected 0 to 1", o.jnd_share));
  expect_option(positive(o.jnd_floor), "switching.jnd_floor",
                fmt::format("is {}, expected a force above 0 [N]", o.jnd_floor));
  expect_option(positive(o.paper_interval), "switching.paper_interval",
                fmt::format("is {}, expected a time above 0 [s]", o.paper_interval));
}

}  // namespace

void check(const SessionOptions& options) {
  check(options.clock);
  check_switch(options.switching);
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
