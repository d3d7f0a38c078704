#include "scheduling/shape/shape_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "geometry/common/quantiles.hpp"
#include "scheduling/judge/patience.hpp"

namespace forefeel {
namespace {

constexpr double least_displacement = 1e-4;  // least denominator of relative errors [m]

std::vector<std::size_t> chosen(std::size_t shapes, std::size_t checks) {
  std::vector<std::size_t> records;
  const std::size_t n = std::min(shapes, checks);
  for (std::size_t i = 0; i < n; ++i) records.push_back((2 * i + 1) * shapes / (2 * n));
  return records;
}

Label label_at(double t, const std::vector<FrameRecord>& frames) {
  const auto found = std::ranges::lower_bound(frames, t - 1e-9, {}, &FrameRecord::t);
  return found != frames.end() ? found->label : frames.empty() ? Label::blank : frames.back().label;
}

CheckedShape compare(const ShapeLog& log, std::size_t which, const std::vector<double>& truth,
                     std::vector<float>& u) {
  log.displacements(log.records()[which], u);
  std::vector<double> errors;
  double largest = least_displacement;
  for (std::size_t i = 0; i < log.nodes().size(); ++i) {
    const Vec3 exact = Eigen::Map<const Vec3>(truth.data() + 3 * static_cast<std::size_t>(log.nodes()[i]));
    largest = std::max(largest, exact.norm());
    errors.push_back((Eigen::Map<const Eigen::Vector3f>(u.data() + 3 * i).cast<double>() - exact).norm());
  }
  std::ranges::sort(errors);
  return {.record = which,
          .error = errors.back() / largest,
          .node_p95 = quantile(errors, 0.95, QuantileRule::inverted_cdf) / largest};
}

}  // namespace

std::vector<CheckedShape> check_shapes(const ShapeLog& log, ReferenceService& references,
                                       const StopOptions& stop, SessionResult& result,
                                       const ShowProgress& show) {
  std::vector<std::size_t> touched;  // all records where the contact has one place
  for (std::size_t i = 0; i < log.records().size(); ++i)
    if (!log.at_sites() || log.records()[i].site.exists()) touched.push_back(i);
  std::vector<std::size_t> records;
  for (const std::size_t i : chosen(touched.size(), log.options().checks)) records.push_back(touched[i]);
  const auto from_site = [&](const ShapeRecord& record) { return Vec3(record.at - record.site.at); };
  for (const std::size_t which : records)
    references.request(from_site(log.records()[which]), log.records()[which].site);
  Patience patience(stop);
  std::vector<CheckedShape> checked;
  std::vector<float> u;
  std::size_t late = 0, failed = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const ShapeRecord& record = log.records()[records[i]];
    const std::optional<State> truth = patience.wait_for(from_site(record), references, false, record.site);
    if (!truth)
      ++late;
    else if (!truth->usable() || !truth->displacements)
      ++failed;
    else
      checked.push_back(compare(log, records[i], *truth->displacements, u));
    if (truth && !checked.empty() && checked.back().record == records[i])
      checked.back().label = label_at(record.t, result.frames);
    if (show)
      show({.phase = SessionPhase::references,
            .t = static_cast<double>(i + 1),
            .seconds = static_cast<double>(records.size()),
            .known = result.states.size()});
  }
  if (late + failed > 0)
    result.notes.push_back(
        fmt::format("{} of {} shapes have no error: {} solves failed, {} were not waited for", late + failed,
                    records.size(), failed, late));
  return checked;
}

}  // namespace forefeel
