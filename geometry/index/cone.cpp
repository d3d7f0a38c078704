#include "geometry/index/cone.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/common/in_best_set.hpp"

namespace forefeel {
namespace {

constexpr double cone_tolerance = 1e-9;  // on cosines
constexpr double beyond_cone = 1e-11;    // a direction lies beyond a facet when it is farther by this
constexpr double flat_direction = 1e-7;  // height below which directions count as coplanar

FOREFEEL_INLINE double largest_product(const double* __restrict x, const double* __restrict y,
                                       const double* __restrict z, std::size_t count, double a, double b,
                                       double c) {
  // Eight separate maxima can be vectorised; the compiler may not reorder a single one.
  double best[8];
  for (double& b8 : best) b8 = -std::numeric_limits<double>::infinity();
  std::size_t i = 0;
  for (; i + 8 <= count; i += 8)
    for (std::size_t k = 0; k < 8; ++k) {
      const double value = a * x[i + k] + b * y[i + k] + c * z[i + k];
      best[k] = value > best[k] ? value : best[k];
    }
  for (; i < count; ++i) best[0] = std::max(best[0], a * x[i] + b * y[i] + c * z[i]);
  for (std::size_t k = 1; k < 8; ++k) best[0] = std::max(best[0], best[k]);
  return best[0];
}

}  // namespace

std::size_t Directions::farthest(const Vec3& axis, double& value) const {
  const std::size_t count = x_.size();
  // Two passes: the maximum vectorises, its index need not.
  const double best =
      in_best_set<largest_product>(x_.data(), y_.data(), z_.data(), count, axis.x(), axis.y(), axis.z());
  std::size_t index = 0;
  double closest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i) {
    const double here = axis.x() * x_[i] + axis.y() * y_[i] + axis.z() * z_[i];
    if (here > closest) {
      closest = here;
      index = i;
      if (here >= best - 1e-15) break;
    }
  }
  value = closest;
  return index;
}

void ConeSolver::push_facet(const Directions& directions, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const Vec3 pa = directions[a], pb = directions[b], pc = directions[c];
  Vec3 normal = (pb - pa).cross(pc - pa);
  const double length = normal.norm();
  if (length == 0) return;
  normal /= length;
  // The mean of the three is better conditioned than one corner.
  double offset = normal.dot(pa + pb + pc) / 3;
  if (offset < normal.dot(inside_)) {
    normal = -normal;
    offset = -offset;
  }
  facets_.push_back({{a, b, c}, normal, offset});
}

// A tetrahedron of four directions that are clearly not coplanar; false (and plane_ set) where there is none.
bool ConeSolver::start(const Directions& directions) {
  facets_.clear();
  const std::size_t count = directions.size();
  std::array<std::size_t, 4> corner{};
  double value = 0;
  corner[1] = directions.farthest(-directions[0], value);
  const Vec3 p = directions[0], q = directions[corner[1]];
  plane_ = p.unitOrthogonal();
  const Vec3 along = q - p;
  if (along.norm() < flat_direction) return false;
  double best = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double area = (directions[i] - p).cross(along).squaredNorm();
    if (area > best) best = area, corner[2] = i;
  }
  Vec3 normal = along.cross(directions[corner[2]] - p);
  if (normal.norm() < flat_direction * along.norm()) {
    plane_ = along.unitOrthogonal();
    return false;
  }
  normal.normalize();
  plane_ = normal;
  double above = 0, below = 0;
  const std::size_t high = directions.farthest(normal, above);
  const std::size_t low = directions.farthest(-normal, below);
  above -= normal.dot(p);
  below += normal.dot(p);
  corner[3] = above >= below ? high : low;
  if (std::max(above, below) < flat_direction) return false;
  inside_ = 0.25 * (p + q + directions[corner[2]] + directions[corner[3]]);
  const auto at = [&](int i) { return static_cast<std::uint32_t>(corner[static_cast<std::size_t>(i)]); };
  push_facet(directions, at(0), at(1), at(2));
  push_facet(directions, at(0), at(1), at(3));
  push_facet(directions, at(0), at(2), at(3));
  push_facet(directions, at(1), at(2), at(3));
  return facets_.size() == 4;
}

// Replaces the facets that `corner` sees by the fan from their rim.
void ConeSolver::add(const Directions& directions, std::uint32_t corner) {
  const Vec3 p = directions[corner];
  kept_.clear();
  rim_.clear();
  const auto toggle = [&](std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const std::array<std::uint32_t, 2> edge{a, b};
    const auto found = std::find(rim_.begin(), rim_.end(), edge);
    if (found == rim_.end()) {
      rim_.push_back(edge);
    } else {
      *found = rim_.back();
      rim_.pop_back();
    }
  };
  for (const ConeFacet& facet : facets_) {
    if (facet.normal.dot(p) <= facet.offset + beyond_cone) {
      kept_.push_back(facet);
      continue;
    }
    toggle(facet.corner[0], facet.corner[1]);
    toggle(facet.corner[1], facet.corner[2]);
    toggle(facet.corner[2], facet.corner[0]);
  }
  facets_.swap(kept_);
  for (const auto& edge : rim_) push_facet(directions, edge[0], edge[1], corner);
}

// Grows the hull at its lowest facet until every facet is at least at cos_threshold (bounded) or the lowest
// one has nothing beyond it (open).
ConeSolver::Stop ConeSolver::grow(const Directions& directions, double cos_threshold, std::size_t& lowest) {
  if (directions.size() < 4 || !start(directions)) return Stop::flat;
  for (std::size_t round = 0; round <= directions.size(); ++round) {
    lowest = 0;
    for (std::size_t i = 1; i < facets_.size(); ++i)
      if (facets_[i].offset < facets_[lowest].offset) lowest = i;
    if (facets_[lowest].offset >= cos_threshold) return Stop::bounded;
    double value = 0;
    const std::size_t corner = directions.farthest(facets_[lowest].normal, value);
    if (value <= facets_[lowest].offset + 4 * beyond_cone) return Stop::open;
    add(directions, static_cast<std::uint32_t>(corner));
  }
  return Stop::open;
}

bool ConeSolver::at_most(const Directions& directions, double cos_threshold, Vec3* witness) {
  std::size_t lowest = 0;
  const Stop stop = grow(directions, cos_threshold - cone_tolerance, lowest);
  if (stop == Stop::bounded) return true;
  if (!witness) return false;
  const EmptyCone cone = finish(directions, stop, lowest);
  const bool wider = cone.cos_half < cos_threshold - cone_tolerance;
  *witness = wider ? cone.axis : Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  return false;
}

// The point of the directions' hull nearest to the origin (Wolfe 1976), for hulls that do not contain it.
Vec3 ConeSolver::nearest_of_hull(const Directions& directions) const {
  std::array<Vec3, 4> corner{directions[0]};
  std::array<double, 4> weight{1.0};
  std::size_t used = 1;
  Vec3 point = corner[0];
  for (int round = 0; round < 200; ++round) {
    double value = 0;
    const std::size_t next = directions.farthest(-point, value);
    if (-value >= point.squaredNorm() - 1e-15) break;
    if (used == 4) break;  // a tetrahedron around the origin: the hull contains it
    corner[used] = directions[next];
    weight[used] = 0;
    ++used;
    for (;;) {
      // The affine minimiser over the corners: [0 1; 1 G][mu; w] = [1; 0] with G the Gram matrix.
      const auto n = static_cast<Eigen::Index>(used);
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 5, 5> system(n + 1, n + 1);
      Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 5, 1> right = decltype(right)::Zero(n + 1);
      right[0] = 1;
      system(0, 0) = 0;
      for (Eigen::Index i = 0; i < n; ++i) {
        system(0, i + 1) = system(i + 1, 0) = 1;
        for (Eigen::Index j = 0; j < n; ++j)
          system(i + 1, j + 1) = corner[static_cast<std::size_t>(i)].dot(corner[static_cast<std::size_t>(j)]);
      }
      const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 5, 1> solved = system.fullPivLu().solve(right);
      double step = 1;
      for (std::size_t i = 0; i < used; ++i) {
        const double target = solved[static_cast<Eigen::Index>(i) + 1];
        if (target < 1e-14 && weight[i] > target) step = std::min(step, weight[i] / (weight[i] - target));
      }
      for (std::size_t i = 0; i < used; ++i)
        weight[i] += step * (solved[static_cast<Eigen::Index>(i) + 1] - weight[i]);
      std::size_t kept = 0;
      for (std::size_t i = 0; i < used; ++i)
        if (weight[i] > 1e-14) corner[kept] = corner[i], weight[kept] = weight[i], ++kept;
      const bool whole = kept == used;
      used = kept;
      if (whole || step == 1 || used <= 1) break;
    }
    point = Vec3::Zero();
    for (std::size_t i = 0; i < used; ++i) point += weight[i] * corner[i];
  }
  return point;
}

EmptyCone ConeSolver::largest_empty(const Directions& directions) {
  std::size_t lowest = 0;
  const Stop stop = grow(directions, std::numeric_limits<double>::infinity(), lowest);
  return finish(directions, stop, lowest);
}

EmptyCone ConeSolver::finish(const Directions& directions, Stop stop, std::size_t lowest) const {
  if (directions.size() == 0) return {};
  if (stop == Stop::open && facets_[lowest].offset >= 0)
    return {facets_[lowest].offset, facets_[lowest].normal};
  const Vec3 point = nearest_of_hull(directions);
  const double distance = point.norm();
  if (distance > 1e-9) return {-std::min(distance, 1.0), -point / distance};
  // The apex lies on the boundary of the hull: gamma = 90 degrees. The axis is a facet's normal, or the plane's.
  if (stop == Stop::open) return {0.0, facets_[lowest].normal};
  return {0.0, plane_};
}

}  // namespace forefeel
