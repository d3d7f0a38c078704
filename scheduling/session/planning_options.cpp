#include "scheduling/session/planning_options.hpp"

#include <fmt/format.h>

#include "scheduling/common/option_check.hpp"

namespace forefeel {

void check(const PlanningOptions& options) {
  detail::expect_option(options.batch >= 0 && options.batch <= 8, "batch",
                        fmt::format("is {}, expected 0 (by the clock) to 8 states", options.batch));
  detail::expect_option(options.audit >= 0 && options.audit <= 0.5, "audit",
                        fmt::format("is {}, expected a share of the solves from 0 to 0.5", options.audit));
  make_policy(options.policy, {});  // unknown names are refused
}

}  // namespace forefeel
