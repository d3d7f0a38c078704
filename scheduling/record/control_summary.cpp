#include "scheduling/record/control_summary.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/common/quantiles.hpp"

namespace forefeel {

ControlSummary control_summary(const SessionResult& result, double error_floor) {
  ControlSummary out{.report = result.safety.passivity};
  if (!out.report.on) return out;
  const double frames = std::max<double>(1, static_cast<double>(result.frames.size()));
  out.coupled_share = static_cast<double>(out.report.coupled) / frames;
  out.drained_share = static_cast<double>(out.report.drained) / frames;
  out.controlled_share = static_cast<double>(out.report.controlled) / frames;
  const std::size_t all = std::min(result.frames.size(), result.safety.uncontrolled.size());
  const std::size_t n = all - std::min(all, result.loop.ending_frames);
  std::vector<double> errors;
  errors.reserve(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Vec3& without = result.safety.uncontrolled[k];
    errors.push_back((result.frames[k].sent - without).norm() / std::max(without.norm(), error_floor));
  }
  std::sort(errors.begin(), errors.end());
  out.added_p50 = quantile(errors, 0.5, QuantileRule::inverted_cdf);
  out.added_p95 = quantile(errors, 0.95, QuantileRule::inverted_cdf);
  out.added_max = quantile(errors, 1, QuantileRule::inverted_cdf);
  return out;
}

}  // namespace forefeel
