#include "approx/error/judged_factors.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

using Widths = std::array<double, bar_levels.size()>;

constexpr double prior_groups = 6;  // nu: groups that the process's own deviation counts as

// Quantiles u of |e| over its root mean square, e of three normal components whose variance is known from n degrees of
// freedom: u^2 has the distribution F(3, n), so u has the density C u^2 (1 + 3 u^2 / n)^(-(n + 3) / 2).
Widths quantiles_of_norm(double n) {
  constexpr double step = 1e-3, farthest = 100;
  const double log_c = std::log(2.0) + 1.5 * std::log(3 / n) + std::lgamma(0.5 * (n + 3)) - std::lgamma(1.5) -
                       std::lgamma(0.5 * n);
  Widths found;
  double share = 0, u = 0;
  for (std::size_t level = 0; level < bar_levels.size(); ++level) {
    for (; share < bar_levels[level] && u < farthest; u += step) {
      const double middle = u + 0.5 * step;
      share +=
          step * std::exp(log_c + 2 * std::log(middle) - 0.5 * (n + 3) * std::log1p(3 * middle * middle / n));
    }
    found[level] = u;
  }
  return found;
}

}  // namespace

double trust_of(const Misfit& of, double each, double shrinkage) {
  const double groups = each * of.samples;
  const double squared = (prior_groups + each * of.missed) / (prior_groups + each * of.share);
  const double believed = std::pow(shrinkage, groups / (groups + prior_groups));
  return std::max({1.0, std::sqrt(squared), std::sqrt(squared) * believed});
}

Widths judged_factors(std::vector<double> scores, double each, double share) {
  const double groups = each * static_cast<double>(scores.size());
  Widths factors = quantiles_of_norm(groups + 1);
  for (std::size_t level = 0; level < factors.size(); ++level) {
    const double p = bar_levels[level];
    if (level > 0) factors[level] = std::max(factors[level], factors[level - 1]);
    if (groups < p / (1 - p)) continue;
    const double rank = std::min(1.0, std::ceil((groups + 1) * p - 1e-9) / groups);
    const double found = quantile_of(scores, rank, QuantileRule::inverted_cdf);
    factors[level] = (prior_groups * factors[level] + each * share * found) / (prior_groups + each * share);
    if (level > 0) factors[level] = std::max(factors[level], factors[level - 1]);
  }
  return factors;
}

}  // namespace forefeel
