#pragma once
// The labels of coverage.hpp at a place, from an octree and a Delaunay triangulation of the same states.
//
// Thresholds have a relative tolerance of 1e-9. In a lattice several of them are met exactly (pi = sqrt(3)/2 h in its
// cells, delta = 1.5 h between its points), and without a tolerance rounding would decide. For the same reason gamma =
// 90 degrees, as on the face of a slab, counts as enclosed if the states are not coplanar.

#include <optional>

#include "geometry/coverage/coverage.hpp"
#include "geometry/index/cone.hpp"
#include "geometry/index/delaunay_index.hpp"
#include "geometry/index/point_octree.hpp"

namespace forefeel {

// CoverageOptions as lengths in metres and cosines, with tolerances.
struct Thresholds {
  Thresholds(const CoverageOptions& options, double spacing, double merge);

  double safe_spread, safe_radius, safe_cos;  // [m], [m], cos of the angle
  double sparse_distance;                     // [m]
  double gap_radius, gap_cos;                 // [m], cos of the angle
  double merge;                               // a state nearer than this counts as being at q [m]
  bool cell_suffices;                         // the safe angle is at least 90 degrees

  // The thresholds at another spacing: lengths times `factor`, except the merge distance.
  Thresholds scaled(double factor) const;
};

class CoverageQuery {
 public:
  CoverageQuery(const PointOctree& points, const DelaunayIndex& delaunay)
      : points_(points), delaunay_(delaunay) {}

  // near: a state close to q, or an invalid id.
  Coverage coverage(const Vec3& q, const Thresholds& limits) const;
  Label label(const Vec3& q, StateId near, const Thresholds& limits) const;
  Label label(const Vec3& q, PathWalk& walk, const Thresholds& limits) const;

  // True if gamma(q, radius) <= arccos(cosine). If false, *witness is the axis of a wider empty cone.
  bool enclosed(const Vec3& q, double radius, double cosine, double merge, Vec3* witness = nullptr) const;
  bool safe_cone(const Vec3& q, const Spread& spread, const Thresholds& limits,
                 Vec3* witness = nullptr) const;
  EmptyCone largest_empty_cone(const Vec3& q, double radius, double merge) const;

  const PointOctree& points() const { return points_; }
  const DelaunayIndex& delaunay() const { return delaunay_; }

 private:
  Label label_with(const Vec3& q, const Spread& spread, const Thresholds& limits) const;

  const PointOctree& points_;
  const DelaunayIndex& delaunay_;
};

}  // namespace forefeel
