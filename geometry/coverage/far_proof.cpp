#include "geometry/coverage/far_proof.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {

// The margin (1 + |c|) e covers the points within e:
//   a . (d - s) <= a . d + e   and   c |d - s| >= c |d| - |c| e   for |s| <= e.
bool FarProof::find_axis(const Vec3& q, double radius, double cosine, double e, Vec3& axis) const {
  const double margin = (1 + std::abs(cosine)) * e;
  constexpr double slack = 2e-9, spare = 0.01;
  for (int turn = 0; turn < 6; ++turn) {
    Vec3 d;
    if (!points_->find_in_cone(q, axis, cosine - slack, margin, radius + e, d)) return true;
    const double length = d.norm();
    if (!(length > 0)) return false;
    const Vec3 u = d / length;
    const double wanted = cosine - margin / length - spare;
    const Vec3 aside = axis - axis.dot(u) * u;
    const double width = aside.norm();
    if (wanted <= -1 || width < 1e-6) return false;
    axis = wanted * u + std::sqrt(1 - wanted * wanted) / width * aside;
    axis.normalize();
  }
  return false;
}

std::optional<Label> FarProof::label(const Thresholds& limits, const Vec3& q, double e, const Vec3& nearest,
                                     Vec3& axis) {
  if (!(std::abs(axis.squaredNorm() - 1) < 0.1)) axis = -nearest;
  axis.normalize();
  if (find_axis(q, limits.gap_radius, limits.gap_cos, e, axis)) return Label::blank;
  // A move by e turns a direction by at most asin(e / nearest), so a correspondingly smaller angle at q proves the
  // label for all voxels.
  directions_.clear();
  points_->for_each_within(q, limits.gap_radius - e, [&](std::uint32_t, const Vec3& offset, double squared) {
    directions_.push(offset / std::sqrt(squared));
  });
  const double turn = std::asin(std::min(1.0, e / nearest.norm())) + 1e-9;
  const double angle = std::acos(std::clamp(limits.gap_cos, -1.0, 1.0));
  if (angle > turn && solver_.at_most(directions_, std::cos(angle - turn), &axis)) return Label::gap;
  if (!axis.allFinite() || !find_axis(q, limits.gap_radius, limits.gap_cos, e, axis)) return std::nullopt;
  return Label::blank;
}

}  // namespace forefeel
