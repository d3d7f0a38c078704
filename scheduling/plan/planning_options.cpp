#include "scheduling/plan/planning_options.hpp"

#include <fmt/format.h>

#include "scheduling/common/option_check.hpp"

namespace forefeel {

void check(const PlanningOptions& options) {
  detail::expect_option(options.batch >= 0 && options.batch <= 8, "batch",
                        fmt::format("is {}, expected 0 (by the clock) to 8 states", options.batch));
  make_policy(options.policy, {});  // unknown names are refused
}

}  // namespace forefeel
