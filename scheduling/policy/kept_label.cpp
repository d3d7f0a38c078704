#include "scheduling/policy/kept_label.hpp"

namespace forefeel {

KeptLabel label_at(const StateSpace& space, const Vec3& q, const Thresholds& limits,
                   const PointOctree::Neighbour& nearest) {
  const PointOctree& points = space.points();
  const CoverageQuery query(points, space.delaunay());
  if (nearest.id != PointOctree::nobody && nearest.squared <= limits.sparse_distance * limits.sparse_distance)
    return {query.label(q, {nearest.id}, limits)};  // safe places lie within this distance, too
  if (points.size() == 0) return {};
  Vec3 witness = Vec3::Zero();
  const bool gap = query.enclosed(q, limits.gap_radius, limits.gap_cos, limits.merge, &witness);
  return {gap ? Label::gap : Label::blank, witness.allFinite() ? witness : Vec3(Vec3::Zero())};
}

KeptLabel label_at(const StateSpace& space, const Vec3& q, const Thresholds& limits) {
  return label_at(space, q, limits, space.points().nearest(q, limits.sparse_distance));
}

bool may_change(const KeptLabel& kept, const Vec3& q, const Vec3& p, double H, const Thresholds& limits) {
  if (kept.label == Label::safe) return false;
  const Vec3 to = p - q;
  const double distance = to.norm();
  const bool blank = kept.label == Label::blank;
  if (distance > (blank ? 8 : 2) * H) return false;
  if (!blank || kept.axis.isZero(0) || distance <= 1.001 * limits.sparse_distance) return true;
  return kept.axis.dot(to) > (limits.gap_cos - 1e-6) * distance;
}

}  // namespace forefeel
