#include "scheduling/record/touch_summary.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/common/quantiles.hpp"
#include "scheduling/touch/surface_models.hpp"

namespace forefeel {

bool is_jet_at_rest(const DispatchRecord& d) {
  return d.choice.site.allFinite() && d.displacement().isZero(0);
}

std::size_t jets_at_rest(const SessionResult& result) {
  return static_cast<std::size_t>(std::ranges::count_if(result.dispatch, [](const DispatchRecord& d) {
    return d.status == DispatchStatus::solved && is_jet_at_rest(d);
  }));
}

namespace {

void add_sliding(const FrameRecord& frame, const FrameRecord* before, const TouchTask& task,
                 TouchNumbers& touches) {
  if (before && before->touch.kind != TouchKind::none)
    touches.slid += (frame.touch.site.at - before->touch.site.at).norm();
  const double friction = task.friction.value_or(0);
  if (!(friction > 0) || !std::isfinite(frame.touch.slope) || frame.touch.at_border ||
      (task.patches && task.patches->is_on_edge(frame.touch.site)))
    return;
  const double off = std::abs(frame.touch.slope - friction) / friction;
  touches.cone = std::isfinite(touches.cone) ? std::max(touches.cone, off) : off;
}

}  // namespace

TouchNumbers touches_of(const SessionResult& result, const TouchTask& task) {
  TouchNumbers touches;
  std::vector<double> angles;
  std::size_t touching = 0, slipping = 0;
  const FrameRecord* before = nullptr;
  for (const FrameRecord& frame : result.frames) {
    touches.lost += frame.touch.lost;
    if (frame.touch.kind != TouchKind::none) {
      ++touching;
      touches.count += !before || before->touch.kind == TouchKind::none;
      touches.stored = std::max(touches.stored, frame.touch.energy);
      const double push = frame.undamped.dot(frame.touch.normal), size = frame.undamped.norm();
      if (size > 1e-3) angles.push_back(std::acos(std::clamp(push / size, -1.0, 1.0)));
    }
    if (frame.touch.kind == TouchKind::slip) ++slipping, add_sliding(frame, before, task, touches);
    before = &frame;
  }
  touches.time =
      static_cast<double>(touching) / static_cast<double>(std::max<std::size_t>(1, result.frames.size()));
  touches.slipping = touching > 0 ? static_cast<double>(slipping) / static_cast<double>(touching) : unknown;
  if (!angles.empty())
    touches.angle_p50 = quantile_of(angles, 0.5), touches.angle_p95 = quantile_of(angles, 0.95);
  touches.jets = jets_at_rest(result);
  return touches;
}

}  // namespace forefeel
