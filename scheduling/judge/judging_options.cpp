#include "scheduling/judge/judging_options.hpp"

#include <fmt/format.h>

#include "scheduling/common/option_check.hpp"

namespace forefeel {

void check(const JudgingOptions& o) {
  using detail::expect_option, detail::positive;
  expect_option(positive(o.error_floor), "error_floor",
                fmt::format("is {}, expected a force above 0 N", o.error_floor));
  expect_option(positive(o.reference_step), "reference_step",
                fmt::format("is {}, expected a length above 0 m", o.reference_step));
  expect_option(o.visit_cell == 0 || (positive(o.visit_cell) && o.visit_cell >= 1e-9), "visit_cell",
                fmt::format("is {}, expected 0 (the spacing) or a length of at least 1e-9 m", o.visit_cell));
  expect_option(o.visit_stride >= 1, "visit_stride",
                fmt::format("is {}, expected 1 (every first visit) or more", o.visit_stride));
}

}  // namespace forefeel
