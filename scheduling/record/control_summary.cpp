#include "scheduling/record/control_summary.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/common/quantiles.hpp"

namespace forefeel {

ControlSummary control_summary(const SafetyReport& safety, std::span<const Vec3> sent, std::size_t frames,
                               double error_floor) {
  ControlSummary out{.report = safety.passivity};
  if (!out.report.on) return out;
  const double all = std::max<double>(1, static_cast<double>(frames));
  out.coupled_share = static_cast<double>(out.report.coupled) / all;
  out.drained_share = static_cast<double>(out.report.drained) / all;
  out.controlled_share = static_cast<double>(out.report.controlled) / all;
  const std::size_t n = std::min(sent.size(), safety.uncontrolled.size());
  std::vector<double> errors;
  errors.reserve(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Vec3& without = safety.uncontrolled[k];
    errors.push_back((sent[k] - without).norm() / std::max(without.norm(), error_floor));
  }
  std::sort(errors.begin(), errors.end());
  out.added_p50 = quantile(errors, 0.5, QuantileRule::inverted_cdf);
  out.added_p95 = quantile(errors, 0.95, QuantileRule::inverted_cdf);
  out.added_max = quantile(errors, 1, QuantileRule::inverted_cdf);
  return out;
}

ControlSummary control_summary(const SessionResult& result, double error_floor) {
  std::vector<Vec3> sent;
  const std::size_t all = result.frames.size();
  for (std::size_t k = 0; k + std::min(all, result.loop.ending_frames) < all; ++k)
    sent.push_back(result.frames[k].sent);
  return control_summary(result.safety, sent, all, error_floor);
}

}  // namespace forefeel
