#include "approx/error/known_within.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace forefeel {
namespace {

constexpr std::size_t least_safe = 20;
constexpr double share = 0.95, wider = 1.5;

}  // namespace

KnownWithin known_within(std::span<const BarSample> samples, const Tolerance& tolerance) {
  KnownWithin found{.samples = samples.size()};
  for (const BarSample& s : samples) {
    if (!(s.bar[1] <= tolerance.limit(s.predicted))) continue;
    ++found.called;
    found.true_ones += s.error <= tolerance.limit(s.force) ? 1 : 0;
  }
  return found;
}

SpacingAdvice advise_spacing(std::span<const BarSample> samples, const Tolerance& tolerance,
                             double safe_spread) {
  std::vector<std::pair<double, bool>> by_spread;  // spread, within
  for (const BarSample& s : samples)
    if (std::isfinite(s.spread)) by_spread.emplace_back(s.spread, s.error <= tolerance.limit(s.force));
  std::ranges::sort(by_spread, {}, &std::pair<double, bool>::first);
  SpacingAdvice advice;
  std::size_t within = 0;
  for (std::size_t i = 0; i < by_spread.size(); ++i) {
    within += by_spread[i].second ? 1 : 0;
    const bool last = i + 1 == by_spread.size();
    if (!last && by_spread[i + 1].first <= by_spread[i].first * (1 + 1e-9))
      continue;  // equal spreads count together
    if (i + 1 < least_safe || static_cast<double>(within) < share * static_cast<double>(i + 1)) continue;
    advice = {.spacing = by_spread[i].first / safe_spread, .safe = i + 1, .within = within, .all = last};
  }
  for (std::size_t i = advice.safe; i < by_spread.size() && !std::isnan(advice.spacing); ++i) {
    if (by_spread[i].first > wider * safe_spread * advice.spacing) break;
    ++advice.wider;
    advice.wider_within += by_spread[i].second ? 1 : 0;
  }
  return advice;
}

}  // namespace forefeel
