#include "scheduling/record/summary_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "geometry/common/quantiles.hpp"
#include "geometry/common/tolerance.hpp"
#include "scheduling/touch/surface_models.hpp"

namespace forefeel {

ToleranceShare tolerance_share(const SessionResult& result, const Tolerance& tolerance) {
  ToleranceShare share;
  for (const FrameRecord& f : result.frames) {
    const bool viscous =
        std::isfinite(f.judged.elastic_reference.x());  // the bars belong to the elastic force
    const Vec3& rendered = viscous ? f.elastic : f.force;
    const bool known = f.bar.half_width[1] <= tolerance.limit(rendered.norm());
    ++share.frames;
    share.frames_known += known ? 1 : 0;
    if (!f.judged.sampled || !std::isfinite(f.judged.error)) continue;
    const Vec3& truth = viscous ? f.judged.elastic_reference : f.judged.reference;
    const bool within = (rendered - truth).norm() <= tolerance.limit(truth.norm());
    ++share.samples;
    share.known += known ? 1 : 0;
    share.within += within ? 1 : 0;
    share.known_true += known && within ? 1 : 0;
  }
  return share;
}

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
  if (!(friction > 0) || !std::isfinite(frame.touch.slope) || frame.touch.at_border || frame.touch.snaps)
    return;
  const double off = std::abs(frame.touch.slope - friction) / friction;
  touches.cone = std::isfinite(touches.cone) ? std::max(touches.cone, off) : off;
}

}  // namespace

namespace {

// The edges that a slide may end at, and what holds a site that is far from its tip.
class Holders {
 public:
  explicit Holders(const TouchTask& task)
      : friction_(task.friction.value_or(0)), radius_(task.field->rest().pad().radius()) {
    const SurfaceMap& map = task.field->rest().map();
    for (std::size_t f = 0; f < map.facets().size(); ++f) {
      const auto facet = static_cast<std::int32_t>(f);
      if (map.facets()[f].clamped) continue;
      const std::array<Vec3, 3> corner = map.corners(facet);
      for (std::size_t side = 0; side < 3; ++side)
        if (map.smooth().keeps(facet, side)) edges_.push_back({corner[side], corner[(side + 1) % 3]});
    }
  }

  void add(const TouchRecord& touch) { ++times_[static_cast<std::size_t>(of(touch))]; }
  SiteHolder most() const {
    return static_cast<SiteHolder>(std::ranges::max_element(times_) - times_.begin());
  }

 private:
  SiteHolder of(const TouchRecord& touch) const {
    constexpr double much = 0.5;  // of what friction can hold
    if (touch.at_border) return SiteHolder::clamp;
    if (touch.snaps) return SiteHolder::lag;
    if (friction_ > 0 && touch.slope >= much * friction_) return SiteHolder::friction;
    return beside_edge(touch.site.at) ? SiteHolder::edge : SiteHolder::minimum;
  }
  bool beside_edge(const Vec3& at) const {
    return std::ranges::any_of(edges_, [&](const std::array<Vec3, 2>& edge) {
      const Vec3 way = edge[1] - edge[0];
      const double along = std::clamp((at - edge[0]).dot(way) / way.squaredNorm(), 0.0, 1.0);
      return (at - edge[0] - along * way).norm() < radius_;
    });
  }

  double friction_, radius_;
  std::vector<std::array<Vec3, 2>> edges_;
  std::array<std::size_t, 5> times_{};
};

}  // namespace

TouchNumbers touches_of(const SessionResult& result, const TouchTask& task) {
  TouchNumbers touches;
  std::vector<double> angles;
  std::size_t touching = 0, slipping = 0, beyond = 0, out = 0;
  double out_for = 0, longest = 0;
  Holders holders(task);
  const double reach = reach_of(task.depth);
  touches.friction = task.friction.value_or(unknown);
  const FrameRecord* before = nullptr;
  for (const FrameRecord& frame : result.frames) {
    touches.lost += frame.touch.lost;
    if (frame.touch.kind != TouchKind::none) {
      ++touching;
      if ((frame.at - frame.touch.site.at).norm() > reach) ++beyond, holders.add(frame.touch);
      out += frame.touch.snaps;
      out_for = frame.touch.snaps ? out_for + (before ? frame.t - before->t : 0) : 0;
      longest = std::max(longest, out_for);
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
  if (touching > 0) {
    touches.slipping = static_cast<double>(slipping) / static_cast<double>(touching);
    touches.beyond = static_cast<double>(beyond) / static_cast<double>(touching);
    touches.out_of_cone = static_cast<double>(out) / static_cast<double>(touching);
    touches.out_of_cone_longest = longest;
    touches.holder = holders.most();
  }
  if (!angles.empty())
    touches.angle_p50 = quantile_of(angles, 0.5), touches.angle_p95 = quantile_of(angles, 0.95);
  touches.jets = jets_at_rest(result);
  return touches;
}

std::string out_of_cone_in_words(const TouchNumbers& touch) {
  return fmt::format(
      "site was out of the cone of friction, catching up, for {:.2g} % of the time in touch, up to {:.2g} s "
      "on end",
      100 * touch.out_of_cone, touch.out_of_cone_longest);
}

}  // namespace forefeel
