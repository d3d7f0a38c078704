#include "solver/jet/surface_map.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "solver/body/pad_quadrature.hpp"

namespace forefeel {
namespace {

// The nodes of the mesh without what the surface does not need.
TetMesh nodes_of(const TetMesh& mesh) {
  TetMesh nodes;
  nodes.nodes = mesh.nodes;
  return nodes;
}

}  // namespace

SurfaceMap::SurfaceMap(const Body& body) : mesh_(nodes_of(body.mesh)) {
  std::map<std::array<NodeIndex, 2>, std::vector<std::array<std::int32_t, 2>>> edges;  // facet, side
  for (const Triangle& triangle : boundary_triangles(body.mesh)) {
    Facet facet{.corners = triangle};
    const Vec3 &a = mesh_.nodes[triangle[0]], &b = mesh_.nodes[triangle[1]], &c = mesh_.nodes[triangle[2]];
    const Vec3 twice = (b - a).cross(c - a);
    facet.area = 0.5 * twice.norm();
    facet.normal = twice.normalized();
    facet.clamped = std::ranges::all_of(
        triangle, [&](NodeIndex node) { return std::ranges::binary_search(body.clamp, node); });
    for (std::int32_t side = 0; side < 3; ++side) {
      const NodeIndex p = triangle[static_cast<std::size_t>(side)],
                      q = triangle[static_cast<std::size_t>((side + 1) % 3)];
      edges[{std::min(p, q), std::max(p, q)}].push_back({static_cast<std::int32_t>(facets_.size()), side});
    }
    if (!facet.clamped) free_area_ += facet.area;
    sums_.push_back(free_area_);
    facets_.push_back(facet);
  }
  for (const auto& [edge, sides] : edges) {
    if (sides.size() != 2) continue;
    for (std::size_t i = 0; i < 2; ++i)
      facets_[static_cast<std::size_t>(sides[i][0])].beside[static_cast<std::size_t>(sides[i][1])] =
          sides[1 - i][0];
  }
}

std::array<Vec3, 3> SurfaceMap::corners(std::int32_t facet) const {
  const Triangle& t = facets_[static_cast<std::size_t>(facet)].corners;
  return {mesh_.nodes[t[0]], mesh_.nodes[t[1]], mesh_.nodes[t[2]]};
}

Vec3 SurfaceMap::barycentric(const SurfacePlace& place) const {
  const auto [a, b, c] = corners(place.facet);
  const Vec3& n = facet(place).normal;
  const double whole = n.dot((b - a).cross(c - a));
  return Vec3(n.dot((b - place.at).cross(c - place.at)), n.dot((c - place.at).cross(a - place.at)),
              n.dot((a - place.at).cross(b - place.at))) /
         whole;
}

SurfacePlace SurfaceMap::nearest(const Vec3& point) const {
  SurfacePlace best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    const auto [a, b, c] = corners(static_cast<std::int32_t>(f));
    const Vec3 at = pad_quadrature::nearest_in_triangle(point, a, b, c);
    const double distance = (at - point).squaredNorm();
    // of facets that share the nearest corner or edge, one that is not clamped
    const bool nearer = distance < least * (1 - 1e-12), freer = distance <= least * (1 + 1e-12) &&
                                                                best.facet >= 0 && facet(best).clamped &&
                                                                !facets_[f].clamped;
    if (nearer || freer) best = {static_cast<std::int32_t>(f), at}, least = std::min(least, distance);
  }
  return best;
}

bool SurfaceMap::inside(const Vec3& point) const {
  double angle = 0;  // A. van Oosterom and J. Strackee, The solid angle of a plane triangle, 1983
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    auto [a, b, c] = corners(static_cast<std::int32_t>(f));
    a -= point, b -= point, c -= point;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle > 2 * std::numbers::pi;
}

double SurfaceMap::thickness(const SurfacePlace& place, const Vec3& normal) const {
  constexpr double in_plane = 1e-9;
  if (!(facet(place).normal.dot(normal) > 0)) return std::numeric_limits<double>::infinity();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    if (static_cast<std::int32_t>(f) == place.facet || !(facets_[f].normal.dot(normal) < -in_plane)) continue;
    const auto [a, b, c] = corners(static_cast<std::int32_t>(f));
    const double depth = facets_[f].normal.dot(place.at - a) / facets_[f].normal.dot(normal);
    const Vec3 at = place.at - depth * normal;
    const auto is_left = [&](const Vec3& p, const Vec3& q) {
      return (q - p).cross(at - p).dot(facets_[f].normal) >= -in_plane * (q - p).squaredNorm();
    };
    if (depth > 0 && depth < least && is_left(a, b) && is_left(b, c) && is_left(c, a)) least = depth;
  }
  return least;
}

SurfacePlace SurfaceMap::random(std::mt19937_64& random) const {
  std::uniform_real_distribution<double> share(0, 1);
  const auto at = std::ranges::upper_bound(sums_, share(random) * free_area_);
  const auto f = static_cast<std::int32_t>(std::min(at - sums_.begin(), std::ssize(sums_) - 1));
  const auto [a, b, c] = corners(f);
  const double root = std::sqrt(share(random)), t = share(random);
  return {f, (1 - root) * a + root * (1 - t) * b + root * t * c};
}

SurfaceMap::Walk SurfaceMap::walk(const SurfacePlace& from, const Vec3& step) const {
  constexpr int most_facets = 1000;
  Walk walk{.end = from};
  const Vec3& first = facet(from).normal;
  Vec3 way = step - first.dot(step) * first, gone = Vec3::Zero();
  std::int32_t came_from = -1;
  for (int count = 0; count < most_facets; ++count) {
    const Facet& here = facet(walk.end);
    const std::array<Vec3, 3> corner = corners(walk.end.facet);
    double share = 1;
    std::size_t side = 3;
    for (std::size_t e = 0; e < 3; ++e) {
      if (came_from >= 0 && here.beside[e] == came_from) continue;
      const Vec3 edge = corner[(e + 1) % 3] - corner[e], out = edge.cross(here.normal);
      const double speed = out.dot(way);
      if (speed <= 1e-14 * out.norm() * way.norm()) continue;
      const double t = std::max(0.0, out.dot(corner[e] - walk.end.at) / speed);
      if (t < share) share = t, side = e;
    }
    walk.end.at += share * way;
    gone += share * way;
    way *= 1 - share;
    if (side == 3) break;
    const std::int32_t next = here.beside[side];
    if (next < 0 || facets_[static_cast<std::size_t>(next)].clamped) {
      walk.whole = false;
      break;
    }
    const Vec3 edge = (corner[(side + 1) % 3] - corner[side]).normalized(),
               to = facets_[static_cast<std::size_t>(next)].normal;
    const double cosine = here.normal.dot(to), sine = edge.dot(here.normal.cross(to));
    const Eigen::AngleAxisd turn(std::atan2(sine, cosine), edge);
    way = turn * way, gone = turn * gone;
    came_from = walk.end.facet;
    walk.end.facet = next;
  }
  walk.step = gone;
  return walk;
}

}  // namespace forefeel
