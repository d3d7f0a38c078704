#include "geometry/coverage/octree_index.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/common/error.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/voxels.hpp"
#include "geometry/index/cone.hpp"

namespace forefeel {
namespace {

constexpr double merge = 1e-9;  // in spacings: a state nearer than this is at q itself

// The 26 directions to the neighbours of a cube.
std::array<Vec3, 26> make_directions() {
  std::array<Vec3, 26> all;
  std::size_t n = 0;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        if (x || y || z) all[n++] = Vec3(x, y, z).normalized();
  return all;
}

}  // namespace

OctreeIndex::OctreeIndex(double spacing, CoverageOptions options) : spacing_(spacing), options_(options) {
  if (!(spacing > 0)) throw InputError("spacing", "is " + std::to_string(spacing) + ", expected > 0");
}

OctreeIndex::OctreeIndex(AdaptiveLattice lattice, CoverageOptions options)
    : spacing_(lattice.coarsest()),
      options_(options),
      lattice_(std::make_unique<AdaptiveLattice>(std::move(lattice))) {}

void OctreeIndex::insert(StateId id, const Vec3& at) {
  if (at_.size() <= id.value)
    at_.resize(std::max<std::size_t>(id.value + 1, 2 * at_.size()), Vec3::Constant(unknown));
  at_[id.value] = at;
  points_.insert(id.value, at);
}

bool OctreeIndex::erase(StateId id) {
  if (id.value >= at_.size() || !points_.erase(id.value, at_[id.value])) return false;
  at_[id.value] = Vec3::Constant(unknown);
  version_ = next_version();
  return true;
}

// One range query around q answers safe and sparse.
OctreeIndex::Near OctreeIndex::look_near(const Vec3& q, double s) const {
  thread_local std::vector<Vec3> offsets;
  thread_local std::vector<std::uint32_t> ids;
  thread_local Directions directions;
  thread_local ConeSolver solver;
  offsets.clear();
  ids.clear();
  Near result;
  const double rho = options_.safe_cone_radius * s * (1 + threshold_slack),
               reach = options_.sparse_distance * s * (1 + threshold_slack);
  double nearest = std::numeric_limits<double>::infinity();
  points_.for_each_within(q, std::max(rho, reach), [&](std::uint32_t id, const Vec3& offset, double squared) {
    nearest = std::min(nearest, squared);
    if (squared > rho * rho) return;
    offsets.push_back(offset);
    ids.push_back(id);
  });
  result.any = nearest <= reach * reach;
  if (!result.any) return result;
  result.local = least_spread(offsets, s);
  if (!(result.local.spread <= options_.safe_spread * s * (1 + threshold_slack))) return result;
  const double here = merge * s;
  if (result.local.solid && nearest > here * here && options_.safe_angle_deg >= 90) {
    result.safe = true;
    for (std::size_t i = 0; i < 4; ++i) result.corner[i] = {ids[result.local.corner[i]]};
    return result;
  }
  // At a state, in a flat tetrahedron, or for a smaller angle the directions decide.
  directions.clear();
  for (const Vec3& offset : offsets)
    if (const double length = offset.norm(); length > here) directions.push(offset / length);
  result.local.solid = false;
  result.safe = solver.at_most(directions, std::cos(options_.safe_angle_deg * std::numbers::pi / 180));
  return result;
}

// min over the 26 directions a of max over occupied leaves of a . u: the cosine that gamma approximates.
// Stops once the value has reached `enough`.
double OctreeIndex::least_side(const Vec3& q, double radius, double enough) const {
  static const std::array<Vec3, 26> axes = make_directions();
  std::array<double, 26> most;
  most.fill(-1);
  points_.for_each_leaf_within(q, radius, [&](const Vec3& offset) {
    const Vec3 u = offset.normalized();
    double least = 1;
    for (std::size_t i = 0; i < axes.size(); ++i)
      least = std::min(least, most[i] = std::max(most[i], axes[i].dot(u)));
    return least < enough;
  });
  return *std::min_element(most.begin(), most.end());
}

Label OctreeIndex::label(const Vec3& q) const {
  PathWalk nowhere;
  return label(q, nowhere);
}

Label OctreeIndex::label(const Vec3& q, PathWalk& walk) const {
  if (points_.size() == 0) return Label::blank;
  const double s = spacing_at(q);
  std::array<double, 4> weight;
  if (walk.version == version_ && options_.safe_angle_deg >= 90 && walk.holds(q, weight)) {
    const double limit = options_.safe_spread * s * (1 + threshold_slack),
                 rho = options_.safe_cone_radius * s * (1 + threshold_slack);
    double sum = 0, farthest = 0, nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 4; ++i) {
      const double squared = (walk.at[i] - q).squaredNorm();
      sum += weight[i] * squared;
      farthest = std::max(farthest, squared);
      nearest = std::min(nearest, squared);
    }
    if (sum <= limit * limit && farthest <= rho * rho && nearest > merge * s * merge * s) return Label::safe;
  }
  const Near near = look_near(q, s);
  walk.version = version_;
  walk.cached = false;
  if (near.safe && near.local.solid) {
    walk.states = near.corner;
    std::array<Vec3, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = at_[near.corner[i].value];
    walk.keep(corners);
  }
  if (near.any) return near.safe ? Label::safe : Label::sparse;
  const double enough = std::cos(options_.gap_angle_deg * std::numbers::pi / 180);
  return least_side(q, options_.gap_cone_radius * s, enough) >= enough ? Label::gap : Label::blank;
}

Coverage OctreeIndex::coverage(const Vec3& q) const {
  Coverage result;
  if (points_.size() == 0) return result;
  const double s = spacing_at(q);
  result.delta = std::sqrt(points_.nearest(q).squared);
  const Near near = look_near(q, s);
  result.spread = near.local.spread;
  if (near.safe && near.local.solid) {
    std::array<Vec3, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = at_[near.corner[i].value];
    result.alpha = circumradius(corners);
  }
  if (near.any) {
    result.label = near.safe ? Label::safe : Label::sparse;
    return result;
  }
  const double least = std::clamp(least_side(q, options_.gap_cone_radius * s, 2), -1.0, 1.0);
  result.gamma_deg = std::acos(least) * 180 / std::numbers::pi;
  if (result.gamma_deg <= options_.gap_angle_deg) result.label = Label::gap;
  return result;
}

Agreement compare_indexes(const Regions& regions, const OctreeIndex& octree) {
  Agreement result;
  const VoxelGrid grid(regions.options().box, regions.options().spacing / 4);
  double same = 0, known = 0;
  int longest = 0;
  PathWalk walk;
  for (std::int32_t k = 0; k < grid.count[2]; ++k)
    for (std::int32_t j = 0; j < grid.count[1]; ++j)
      for (std::int32_t i = 0, run = 0; i < grid.count[0]; ++i) {
        const Vec3 q = grid.centre({i, j, k});
        const Label d = regions.label_at(q), o = octree.label(q, walk);
        const double volume = grid.cube({i, j, k}, 1).size().prod();
        result.volume[d][o] += volume;
        if (d != Label::blank || o != Label::blank) known += volume;
        if (d == o && d != Label::blank) same += volume;
        run = d == o ? 0 : run + 1;
        if (run <= longest) continue;
        longest = run;
        const Vec3 middle = grid.centre({i - (run - 1) / 2, j, k});
        result.worst = {middle, regions.label_at(middle), octree.label(middle)};
      }
  if (known > 0) result.share = same / known;
  return result;
}

}  // namespace forefeel
