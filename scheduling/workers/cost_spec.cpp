#include "scheduling/workers/cost_spec.hpp"

#include <fmt/format.h>

#include <cmath>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

constexpr double most = 1e6;  // [s]

std::string text_of(const ConstantCost& cost) {
  return fmt::format("constant:{}", cost.seconds);
}
std::string text_of(const LogNormalCost& cost) {
  return fmt::format("lognormal:{},{}", cost.median, cost.sigma);
}
std::string text_of(PaperCost) {
  return "paper";
}
std::string text_of(RecordedCost) {
  return "recorded";
}
std::string text_of(const Registered& cost) {
  return to_text(cost);
}

void expect_above_zero(const InputPlace& where, double value) {
  if (!(value > 0) || !(value <= most))
    throw InputError(where, fmt::format("'{}' is not a number above 0 and at most 1e6", value));
}

void check_cost(const InputPlace& where, const ConstantCost& cost) {
  expect_above_zero(where, cost.seconds);
}
void check_cost(const InputPlace& where, const LogNormalCost& cost) {
  expect_above_zero(where, cost.median);
  if (!(cost.sigma >= 0) || !(cost.sigma <= most))
    throw InputError(where, fmt::format("'{}' is not a number of at least 0 and at most 1e6", cost.sigma));
}
void check_cost(const InputPlace&, const auto&) {}

}  // namespace

std::string to_text(const CostSpec& cost) {
  if (!cost.written_.empty()) return cost.written_;
  return std::visit([](const auto& model) { return text_of(model); }, cost.cost_);
}

void check(const CostSpec& cost) {
  const InputPlace where{.key = "cost", .value = to_text(cost)};
  std::visit([&](const auto& model) { check_cost(where, model); }, cost.cost());
}

}  // namespace forefeel
