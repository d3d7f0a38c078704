#include "scheduling/shape/shape_options.hpp"

#include <fmt/format.h>

#include <cmath>

#include "scheduling/common/option_check.hpp"

namespace forefeel {

void check(const ShapeOptions& options) {
  using detail::expect_option;
  expect_option(std::isfinite(options.rate) && options.rate >= 0 && options.rate <= 200, "shape_rate",
                fmt::format("is {}, expected 0 to 200 Hz", options.rate));
  expect_option(options.checks <= 10'000, "shape_checks",
                fmt::format("is {}, expected 0 to 10000", options.checks));
  expect_option(options.neighbours >= 1 && options.neighbours <= 200, "shape_neighbours",
                fmt::format("is {}, expected 1 to 200", options.neighbours));
}

}  // namespace forefeel
