#include "solver/jet/surface_map.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
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
  std::vector<SmoothFacet> facets;
  for (const Facet& facet : facets_) facets.push_back({facet.corners, facet.beside});
  smooth_ = SmoothSurface(mesh_.nodes, facets);
}

std::array<Vec3, 3> SurfaceMap::corners(std::int32_t facet) const {
  const Triangle& t = facets_[static_cast<std::size_t>(facet)].corners;
  return {mesh_.nodes[t[0]], mesh_.nodes[t[1]], mesh_.nodes[t[2]]};
}

SurfacePlace SurfaceMap::place(std::int32_t facet, const Vec3& share) const {
  return {facet, smooth_.at(facet, share).at, share};
}

Vec3 SurfaceMap::foot_share(std::int32_t number, const Vec3& at) const {
  const auto [a, b, c] = corners(number);
  const Vec3& n = facets_[static_cast<std::size_t>(number)].normal;
  const double whole = n.dot((b - a).cross(c - a));
  return Vec3(n.dot((b - at).cross(c - at)), n.dot((c - at).cross(a - at)), n.dot((a - at).cross(b - at))) /
         whole;
}

Vec3 SurfaceMap::barycentric(const SurfacePlace& place) const {
  const bool flat = smooth_.is_flat(place.facet);
  if (!flat && !place.share.isZero(0)) return place.share;
  // Of the smooth surface by Newton's method from the foot on the facet.
  constexpr int most_steps = 20;
  constexpr double close = 1e-15;
  Vec3 at = place.at, share = foot_share(place.facet, at);
  const Vec3& n = facet(place).normal;
  for (int i = 0; i < most_steps && !flat; ++i) {
    const SmoothSpot spot = smooth_.at(place.facet, share);
    const Vec3 left = spot.by.inverse() * (place.at - spot.at), step = left - n.dot(left) * n;
    at += step;
    const Vec3 before = share;
    share = foot_share(place.facet, at);
    if ((share - before).norm() < close) break;
  }
  return share;
}

std::array<Vec3, 3> SurfaceMap::flat_slopes(std::int32_t number) const {
  const auto [a, b, c] = corners(number);
  const Vec3& n = facets_[static_cast<std::size_t>(number)].normal;
  const double twice = n.dot((b - a).cross(c - a));
  return {Vec3(n.cross(c - b) / twice), Vec3(n.cross(a - c) / twice), Vec3(n.cross(b - a) / twice)};
}

SurfaceMap::OnFacet SurfaceMap::on_facet(const SurfacePlace& place) const {
  OnFacet where{.share = barycentric(place), .by = flat_slopes(place.facet), .normal = facet(place).normal};
  if (smooth_.is_flat(place.facet)) return where;
  const SmoothSpot spot = smooth_.at(place.facet, where.share);
  const Mat3 back = spot.by.inverse().transpose();
  for (Vec3& slope : where.by) slope = (back * slope).eval();
  where.normal = spot.normal;
  return where;
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
  if (best.facet < 0) return best;
  return smooth_.is_flat(best.facet) ? best : foot_near(best, point);
}

SurfacePlace SurfaceMap::foot_near(const SurfacePlace& on_facet, const Vec3& point) const {
  constexpr int most_steps = 60;
  SurfacePlace best = place(on_facet.facet, foot_share(on_facet.facet, on_facet.at));
  SmoothSpot here = spot(best);
  for (int i = 0; i < most_steps && !facet(best).clamped; ++i) {
    const Vec3 way = point - best.at, step = way - here.normal.dot(way) * here.normal;
    const Walk next = walk(best, here, step);
    const double before = way.squaredNorm(), after = (point - next.end.at).squaredNorm();
    if (!(after < before)) break;
    best = next.end, here = next.spot;
    if (step.squaredNorm() < 1e-24 * before || step.norm() < 1e-13) break;
  }
  return best;
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
  const double root = std::sqrt(share(random)), t = share(random);
  return place(f, {1 - root, root * (1 - t), root * t});
}

SurfaceMap::Walk SurfaceMap::walk(const SurfacePlace& from, const SmoothSpot& start, const Vec3& step) const {
  constexpr int most_facets = 1000;
  Walk walk{.end = from, .spot = start};
  Vec3& share = walk.end.share;
  share = barycentric(from);
  SmoothSpot& spot = walk.spot;
  Vec3 way = step - spot.normal.dot(step) * spot.normal, gone = Vec3::Zero();  // in the tangent plane
  std::int32_t came_from = -1;
  for (int count = 0; count < most_facets; ++count) {
    const Facet& here = facet(walk.end);
    const std::array<Vec3, 3> corner = corners(walk.end.facet);
    const bool flat = smooth_.is_flat(walk.end.facet);
    const Vec3 flat_way = flat ? way : Vec3(spot.by.inverse() * way);
    const Vec3 at =
        flat ? walk.end.at : Vec3(share[0] * corner[0] + share[1] * corner[1] + share[2] * corner[2]);
    double part = 1;
    std::size_t side = 3;
    for (std::size_t e = 0; e < 3; ++e) {
      if (came_from >= 0 && here.beside[e] == came_from) continue;
      const Vec3 edge = corner[(e + 1) % 3] - corner[e], out = edge.cross(here.normal);
      const double speed = out.dot(flat_way);
      if (speed <= 1e-14 * out.norm() * flat_way.norm()) continue;
      const double t = std::max(0.0, out.dot(corner[e] - at) / speed);
      if (t < part) part = t, side = e;
    }
    const Vec3 next_at = at + part * flat_way;
    share = foot_share(walk.end.facet, next_at);
    const double length = way.norm();
    if (!flat) spot = smooth_.at(walk.end.facet, share);
    // The direction here, of the length that is left.
    const Vec3 ahead = flat || !(length > 0) ? way : Vec3((spot.by * flat_way).normalized() * length);
    if (gone.squaredNorm() > 0 && !flat) gone = ahead * (gone.norm() / length);
    gone += part * ahead;
    way = (1 - part) * ahead;
    walk.end.at = flat ? next_at : spot.at;
    if (side == 3) break;
    const std::int32_t next = here.beside[side];
    if (next < 0 || facets_[static_cast<std::size_t>(next)].clamped) {
      walk.whole = false;
      break;
    }
    // The same place on the facet beside.
    Vec3 there = Vec3::Zero();
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k)
        if (facets_[static_cast<std::size_t>(next)].corners[k] == here.corners[i] && i != (side + 2) % 3)
          there[static_cast<int>(k)] = share[static_cast<int>(i)];
    there /= there.sum();
    const Vec3 before = spot.normal;
    came_from = walk.end.facet;
    walk.end.facet = next, share = there;
    spot = smooth_.at(next, share);
    const Vec3 edge = (corner[(side + 1) % 3] - corner[side]).normalized();
    const double cosine = before.dot(spot.normal), sine = edge.dot(before.cross(spot.normal));
    if (std::abs(sine) > 1e-12) {  // a kept edge
      const Eigen::AngleAxisd turn(std::atan2(sine, cosine), edge);
      way = turn * way, gone = turn * gone;
    }
  }
  walk.step = gone;
  return walk;
}

}  // namespace forefeel
