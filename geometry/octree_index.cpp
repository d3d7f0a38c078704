#include "geometry/octree_index.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "geometry/cone.hpp"
#include "geometry/error.hpp"

namespace forefeel {
namespace {

constexpr double slack = 1e-9;

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
  if (at_.size() <= id.value) at_.resize(std::max<std::size_t>(id.value + 1, 2 * at_.size()), Vec3::Constant(unknown));
  at_[id.value] = at;
  points_.insert(id.value, at);
}

bool OctreeIndex::erase(StateId id) {
  if (id.value >= at_.size() || !points_.erase(id.value, at_[id.value])) return false;
  at_[id.value] = Vec3::Constant(unknown);
  return true;
}

// The leaf of q has its corners at multiples of s. A state belongs to the corners whose cube of side s contains it.
bool OctreeIndex::safe(const Vec3& q, double s, double& reach) const {
  const Vec3 centre = s * ((q / s).array().floor() + 0.5).matrix();
  thread_local Directions directions;
  thread_local ConeSolver solver;
  directions.clear();
  unsigned known = 0;
  reach = 0;
  const double limit = s * (1 + slack);
  points_.for_each_within(centre, std::numbers::sqrt3 * limit, [&](std::uint32_t, const Vec3& offset, double) {
    if (offset.cwiseAbs().maxCoeff() > limit) return;
    unsigned corners = 0xff;
    for (int axis = 0; axis < 3; ++axis) {
      constexpr std::array<unsigned, 3> upper{0xaa, 0xcc, 0xf0};
      const unsigned high = upper[static_cast<std::size_t>(axis)];
      if (offset[axis] > slack * s) corners &= high;
      if (offset[axis] < -slack * s) corners &= ~high;
    }
    known |= corners;
    reach = std::max(reach, (offset + centre - q).norm());
  });
  const int count = std::popcount(known);
  if (count >= 7) return true;
  if (count < 3) return false;
  points_.for_each_within(q, options_.safe_cone_radius * limit, [&](std::uint32_t, const Vec3& offset, double squared) {
    if (squared > slack * s * slack * s) directions.push(offset / std::sqrt(squared));
  });
  return solver.at_most(directions, 0.0);
}

// min over the 26 directions a of max over occupied leaves of a . u: the cosine that gamma approximates.
double OctreeIndex::least_side(const Vec3& q, double radius) const {
  static const std::array<Vec3, 26> axes = make_directions();
  std::array<double, 26> most;
  most.fill(-1);
  points_.for_each_leaf_within(q, radius, [&](const Vec3& offset) {
    const Vec3 u = offset.normalized();
    for (std::size_t i = 0; i < axes.size(); ++i) most[i] = std::max(most[i], axes[i].dot(u));
  });
  return *std::min_element(most.begin(), most.end());
}

Label OctreeIndex::label(const Vec3& q) const {
  if (points_.size() == 0) return Label::blank;
  const double s = spacing_at(q);
  double reach = 0;
  if (points_.nearest(q, options_.sparse_distance * s * (1 + slack)).id != 0xffffffffu)
    return safe(q, s, reach) ? Label::safe : Label::sparse;
  const double least = least_side(q, options_.gap_cone_radius * s);
  return least >= std::cos(options_.gap_angle_deg * std::numbers::pi / 180) ? Label::gap : Label::blank;
}

Coverage OctreeIndex::coverage(const Vec3& q) const {
  Coverage result;
  if (points_.size() == 0) return result;
  const double s = spacing_at(q);
  result.delta = std::sqrt(points_.nearest(q).squared);
  double reach = 0;
  if (result.delta <= options_.sparse_distance * s * (1 + slack)) {
    result.label = Label::sparse;
    if (safe(q, s, reach)) {
      result.label = Label::safe;
      result.spread = result.alpha = reach;
    }
    return result;
  }
  const double least = std::clamp(least_side(q, options_.gap_cone_radius * s), -1.0, 1.0);
  result.gamma_deg = std::acos(least) * 180 / std::numbers::pi;
  if (result.gamma_deg <= options_.gap_angle_deg) result.label = Label::gap;
  return result;
}

void OctreeIndex::nearest(const Vec3& q, std::size_t n, std::vector<StateId>& out) const {
  std::vector<PointOctree::Neighbour> found;
  points_.nearest(q, n, found);
  out.clear();
  for (const auto& neighbour : found) out.push_back({neighbour.id});
}

void OctreeIndex::within(const Vec3& q, double radius, std::vector<StateId>& out) const {
  std::vector<PointOctree::Neighbour> found;
  points_.for_each_within(q, radius, [&](std::uint32_t id, const Vec3&, double d) { found.push_back({d, id}); });
  std::sort(found.begin(), found.end());
  out.clear();
  for (const auto& neighbour : found) out.push_back({neighbour.id});
}

std::vector<AdaptiveLattice::Point> OctreeIndex::proposals() const {
  if (!lattice_) return {};
  std::vector<AdaptiveLattice::Point> result = lattice_->points();
  std::erase_if(result, [&](const AdaptiveLattice::Point& point) {
    return points_.nearest(point.at, 0.5 * point.spacing * (1 - slack)).id != 0xffffffffu;
  });
  return result;
}

}  // namespace forefeel
