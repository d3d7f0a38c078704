#include "scheduling/workers/worker_options.hpp"

#include <fmt/format.h>

#include "scheduling/common/option_check.hpp"

namespace forefeel {

void check(const WorkerOptions& o) {
  using detail::expect_option;
  expect_option(o.count >= 1 && o.count <= 100000, "workers",
                fmt::format("is {}, expected 1 to 100000", o.count));
  expect_option(detail::positive(o.batch_share) && o.batch_share <= 1, "batch_share",
                fmt::format("is {}, expected a share above 0, at most 1", o.batch_share));
  expect_option(o.threads >= 0, "threads", fmt::format("is {}, expected 0 (all) or more", o.threads));
  expect_option(o.latency >= 0 && o.latency <= 86400, "latency",
                fmt::format("is {}, expected 0 to 86400 s", o.latency));
  check(o.cost);
}

}  // namespace forefeel
