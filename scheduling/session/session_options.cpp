#include "scheduling/session/session_options.hpp"

#include <fmt/format.h>

#include <cmath>

#include "scheduling/common/option_check.hpp"

namespace forefeel {

using detail::expect_option, detail::positive;

void check(const WorkerOptions& o) {
  expect_option(o.count >= 1 && o.count <= 100000, "workers",
                fmt::format("is {}, expected 1 to 100000", o.count));
  expect_option(positive(o.batch_share) && o.batch_share <= 1, "batch_share",
                fmt::format("is {}, expected a share above 0, at most 1", o.batch_share));
  expect_option(o.threads >= 0, "threads", fmt::format("is {}, expected 0 (all) or more", o.threads));
  expect_option(o.latency >= 0 && o.latency <= 86400, "latency",
                fmt::format("is {}, expected 0 to 86400 s", o.latency));
  check(o.cost);
}

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
