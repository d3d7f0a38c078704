#pragma once
// Proves the label gap or blank for all places within a given distance of a place, if all of them are farther than
// kappa_p h from every state (coverage.hpp).

#include <optional>

#include "geometry/coverage/coverage_query.hpp"

namespace forefeel {

class FarProof {
 public:
  explicit FarProof(const PointOctree& points) : points_(&points) {}

  // Turns `axis` until, seen from every point within e of q, the angle between it and each state within the radius
  // exceeds arccos(cosine). False if six turns do not suffice.
  bool find_axis(const Vec3& q, double radius, double cosine, double e, Vec3& axis) const;

  // Gap or blank for all places within e of q; nothing if neither is proven. nearest: offset of the state nearest
  // to q. axis: a guess (or zero); afterwards, for blank, that of an empty cone.
  std::optional<Label> label(const Thresholds& limits, const Vec3& q, double e, const Vec3& nearest,
                             Vec3& axis);

 private:
  const PointOctree* points_;
  Directions directions_;
  ConeSolver solver_;
};

}  // namespace forefeel
