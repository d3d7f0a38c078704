#include "geometry/common/quantiles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace forefeel {
namespace {

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

void drop_nan(std::vector<double>& values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
}

}  // namespace

double quantile(std::span<const double> sorted, double share, QuantileRule rule) {
  if (sorted.empty()) return no_value;
  const std::size_t n = sorted.size();
  const double place = share * static_cast<double>(n - 1);  // from 0
  switch (rule) {
    case QuantileRule::inverted_cdf: {
      const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(n)));
      return sorted[std::clamp<std::size_t>(rank, 1, n) - 1];
    }
    case QuantileRule::nearest:
      return sorted[static_cast<std::size_t>(std::lround(place))];
    case QuantileRule::linear:
      break;
  }
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, n - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

double quantile_of(std::vector<double> values, double share, QuantileRule rule) {
  drop_nan(values);
  std::ranges::sort(values);
  return quantile(values, share, rule);
}

double median(std::vector<double> values) {
  drop_nan(values);
  if (values.empty()) return no_value;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace forefeel
