#include "geometry/coverage/coverage_query.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "geometry/common/enum_names.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

double cosine_of(double degrees) {
  return std::cos(degrees * std::numbers::pi / 180);
}

struct Scratch {
  Directions directions;
  ConeSolver solver;
};

// Work space, one for each thread: queries are const and may run in several threads.
Scratch& scratch() {
  thread_local Scratch mine;
  return mine;
}

void gather(const PointOctree& points, const Vec3& q, double radius, double merge, Directions& out) {
  out.clear();
  points.for_each_within(q, radius, [&](std::uint32_t, const Vec3& offset, double squared) {
    if (squared > merge * merge) out.push(offset / std::sqrt(squared));
  });
}

}  // namespace

void check_options(const StateSpaceOptions& options) {
  if (!(options.spacing > 0) || !std::isfinite(options.spacing))
    throw InputError("spacing",
                     "is " + std::to_string(options.spacing) + ", expected a positive length in metres");
  // A safe place is within kappa_s h of a state; regions need it to be at least sparse.
  if (!(options.coverage.sparse_distance >= options.coverage.safe_spread))
    throw InputError("coverage",
                     "the sparse distance is below the safe spread, expected it to be at least as large");
}

std::string_view name(Label label) {
  return name_in<Label::blank>({"safe", "sparse", "gap", "blank"}, label);
}

Thresholds::Thresholds(const CoverageOptions& options, double spacing, double merge_distance)
    : safe_spread(options.safe_spread * spacing * (1 + threshold_slack)),
      safe_radius(options.safe_cone_radius * spacing * (1 + threshold_slack)),
      safe_cos(cosine_of(options.safe_angle_deg)),
      sparse_distance(options.sparse_distance * spacing * (1 + threshold_slack)),
      gap_radius(options.gap_cone_radius * spacing * (1 + threshold_slack)),
      gap_cos(cosine_of(options.gap_angle_deg)),
      merge(merge_distance),
      cell_suffices(options.safe_angle_deg >= 90) {}

Thresholds Thresholds::scaled(double factor) const {
  Thresholds result = *this;
  result.safe_spread *= factor;
  result.safe_radius *= factor;
  result.sparse_distance *= factor;
  result.gap_radius *= factor;
  return result;
}

bool CoverageQuery::enclosed(const Vec3& q, double radius, double cosine, double merge, Vec3* witness) const {
  Scratch& mine = scratch();
  gather(points_, q, radius, merge, mine.directions);
  return mine.solver.at_most(mine.directions, cosine, witness);
}

EmptyCone CoverageQuery::largest_empty_cone(const Vec3& q, double radius, double merge) const {
  Scratch& mine = scratch();
  gather(points_, q, radius, merge, mine.directions);
  return mine.solver.largest_empty(mine.directions);
}

// Compares gamma(q, safe_radius) with its limit. If all corners of the cell around q are in reach, and none
// is at q, the cell alone decides.
bool CoverageQuery::safe_cone(const Vec3& q, const Spread& spread, const Thresholds& limits,
                              Vec3* witness) const {
  if (limits.cell_suffices && spread.inside) {
    double farthest = 0, nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& corner : spread.at) {
      const double squared = (corner - q).squaredNorm();
      farthest = std::max(farthest, squared);
      nearest = std::min(nearest, squared);
    }
    if (farthest <= limits.safe_radius * limits.safe_radius && nearest > limits.merge * limits.merge)
      return true;
  }
  return enclosed(q, limits.safe_radius, limits.safe_cos, limits.merge, witness);
}

Label CoverageQuery::label_with(const Vec3& q, const Spread& spread, const Thresholds& limits) const {
  if (spread.spread <= limits.safe_spread && safe_cone(q, spread, limits)) return Label::safe;
  if (points_.nearest(q, limits.sparse_distance).id != 0xffffffffu) return Label::sparse;
  return enclosed(q, limits.gap_radius, limits.gap_cos, limits.merge) ? Label::gap : Label::blank;
}

Label CoverageQuery::label(const Vec3& q, StateId near, const Thresholds& limits) const {
  if (points_.size() == 0) return Label::blank;
  return label_with(q, delaunay_.spread(q, near), limits);
}

Label CoverageQuery::label(const Vec3& q, PathWalk& walk, const Thresholds& limits) const {
  if (points_.size() == 0) return Label::blank;
  return label_with(q, delaunay_.spread(q, walk), limits);
}

Coverage CoverageQuery::coverage(const Vec3& q, const Thresholds& limits) const {
  Coverage result;
  if (points_.size() == 0) return result;
  const PointOctree::Neighbour nearest = points_.nearest(q);
  const Spread spread = delaunay_.spread(q, {nearest.id}, true);
  result.delta = std::sqrt(nearest.squared);
  result.spread = spread.spread;
  result.alpha = spread.alpha;
  if (spread.spread <= limits.safe_spread && safe_cone(q, spread, limits)) {
    result.label = Label::safe;
  } else if (result.delta <= limits.sparse_distance) {
    result.label = Label::sparse;
  } else {
    const EmptyCone cone = largest_empty_cone(q, limits.gap_radius, limits.merge);
    result.gamma_deg = std::acos(std::clamp(cone.cos_half, -1.0, 1.0)) * 180 / std::numbers::pi;
    result.label = cone.cos_half >= limits.gap_cos - threshold_slack ? Label::gap : Label::blank;
  }
  return result;
}

}  // namespace forefeel
