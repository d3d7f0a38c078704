#include "solver/body/pad.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "solver/body/pad_quadrature.hpp"

namespace forefeel {

namespace {

using pad_quadrature::cross;
using pad_quadrature::facing;
using pad_quadrature::nearest_in_triangle;
using pad_quadrature::over_edge;
using pad_quadrature::shapes;
using pad_quadrature::Vec2;

struct Corners {
  Vec3 a, b, c;
  Vec3 nearest(const Vec3& p) const { return nearest_in_triangle(p, a, b, c); }
  Vec3 area() const { return 0.5 * (b - a).cross(c - a); }
};

Corners corners_of(const TetMesh& mesh, const Triangle& t) {
  return {mesh.nodes[t[0]], mesh.nodes[t[1]], mesh.nodes[t[2]]};
}

// Adds int 3 k_p / (pi r^2) (1 - |y - s|^2 / r^2)^2 N_i N_j dA to the facet's springs; returns its area in the ball.
double integrate(const Corners& t, const Pad& pad, PadFacet& facet) {
  const Vec3 area = t.area(), normal = area.normalized();
  const double height = normal.dot(pad.site - t.a), r2 = pad.radius * pad.radius;
  if (height * height >= r2) return 0;
  const Vec3 foot = pad.site - height * normal, e1 = (t.b - t.a).normalized(), e2 = normal.cross(e1);
  const auto flat = [&](const Vec3& p) { return Vec2(e1.dot(p - foot), e2.dot(p - foot)); };
  const std::array<Vec2, 3> corner{flat(t.a), flat(t.b), flat(t.c)};
  const double twice = cross(corner[1] - corner[0], corner[2] - corner[0]);
  const double scale = pad_peak(pad);
  double inside = 0;
  const auto visit = [&](const Vec2& y, double weight) {
    const Vec3 l(cross(corner[1] - y, corner[2] - y) / twice, cross(corner[2] - y, corner[0] - y) / twice,
                 cross(corner[0] - y, corner[1] - y) / twice);
    const double fall = 1 - (height * height + y.squaredNorm()) / r2;
    const std::array<double, 6> n = shapes(l, facet.nodes);
    const double density = weight * scale * fall * fall;
    inside += weight;
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j < 6; ++j) facet.springs[i][j] += density * n[i] * n[j];
  };
  const double disc = std::sqrt(r2 - height * height);
  for (std::size_t e = 0; e < 3; ++e) over_edge(corner[e], corner[(e + 1) % 3], disc, visit);
  return inside;
}

double sum_of(const PadFacet& facet) {
  double sum = 0;
  for (const auto& row : facet.springs)
    for (const double value : row) sum += value;
  return sum;
}

// The triangles of S; near: those that meet the ball.
std::vector<std::size_t> component_at(const TetMesh& mesh, const Pad& pad,
                                      const std::vector<Triangle>& near) {
  std::map<std::array<NodeIndex, 2>, std::vector<std::size_t>> beside;
  std::vector<char> taken(near.size(), 0);
  std::vector<std::size_t> found;
  const auto take = [&](std::size_t t) {
    if (taken[t] == 0) taken[t] = 1, found.push_back(t);
  };
  const auto distance = [&](const Triangle& t) {
    return (corners_of(mesh, t).nearest(pad.site) - pad.site).norm();
  };
  double least = pad.radius;
  for (const Triangle& t : near) least = std::min(least, distance(t));
  for (std::size_t t = 0; t < near.size(); ++t) {
    for (std::size_t e = 0; e < 3; ++e) {
      const NodeIndex a = near[t][e], b = near[t][(e + 1) % 3];
      beside[{std::min(a, b), std::max(a, b)}].push_back(t);
    }
    if (distance(near[t]) <= least + 1e-7 * pad.radius) take(t);
  }
  for (std::size_t next = 0; next < found.size(); ++next)
    for (std::size_t e = 0; e < 3; ++e) {
      const NodeIndex a = near[found[next]][e], b = near[found[next]][(e + 1) % 3];
      const Vec3 nearest = nearest_in_triangle(pad.site, mesh.nodes[a], mesh.nodes[b], mesh.nodes[b]);
      if ((nearest - pad.site).norm() >= pad.radius) continue;
      for (const std::size_t t : beside[{std::min(a, b), std::max(a, b)}]) take(t);
    }
  std::ranges::sort(found);
  return found;
}

}  // namespace

PadSurface pad_surface(const TetMesh& mesh, const Pad& pad, int nodes_per_facet) {
  std::vector<Triangle> near;
  for (const Triangle& t : boundary_triangles(mesh))
    if ((corners_of(mesh, t).nearest(pad.site) - pad.site).norm() < pad.radius) near.push_back(t);
  PadSurface surface;
  Vec3 mean = Vec3::Zero();
  const std::vector<std::size_t> component = component_at(mesh, pad, near);
  for (const std::size_t t : component) {
    PadFacet facet{.corners = near[t], .nodes = nodes_per_facet};
    const Corners corners = corners_of(mesh, near[t]);
    surface.area += integrate(corners, pad, facet);
    mean += sum_of(facet) * corners.area().normalized();
    surface.facets.push_back(facet);
  }
  surface.other_part = component.size() < near.size();
  if (mean.norm() > 1e-9 * pad.stiffness) surface.normal = mean.normalized();
  for (PadFacet& facet : surface.facets) {
    const double share = facing(corners_of(mesh, facet.corners).area().normalized().dot(surface.normal));
    for (auto& row : facet.springs)
      for (double& value : row) value *= share;
    surface.stiffness += sum_of(facet);
  }
  return surface;
}

double pad_peak(const Pad& pad) {
  return 3 * pad.stiffness / (std::numbers::pi * pad.radius * pad.radius);
}

double pad_density(const Pad& pad, const PadSurface& surface, const Vec3& y, const Vec3& normal) {
  const double fall = std::max(0.0, 1 - (y - pad.site).squaredNorm() / (pad.radius * pad.radius));
  return pad_peak(pad) * fall * fall * facing(normal.dot(surface.normal));
}

Vec3 nearest_site(const TetMesh& mesh, const Vec3& point) {
  Vec3 best = point;
  double least = std::numeric_limits<double>::infinity();
  for (const Triangle& t : boundary_triangles(mesh)) {
    const Vec3 at = corners_of(mesh, t).nearest(point);
    const double distance = (at - point).squaredNorm();
    if (distance < least) least = distance, best = at;
  }
  return best;
}

namespace {

constexpr int parts = 16;  // of each edge

// Visits the centroids of the parts^2 equal triangles of a facet, in barycentric coordinates.
template <class Visit>
void over_parts(const Visit& visit) {
  for (int i = 0; i < parts; ++i)
    for (int j = 0; i + j < parts; ++j)
      for (const double shift : {1.0 / 3, 2.0 / 3}) {
        if (shift > 0.5 && i + j + 1 >= parts) continue;
        const double a = (i + shift) / parts, b = (j + shift) / parts;
        visit(Vec3(1 - a - b, a, b));
      }
}

}  // namespace

double pulling_share(const Body& body, std::span<const double> displacements, const Vec3& x) {
  if (!body.pad || x.isZero(0)) return 0;
  const Pad& pad = *body.pad;
  const PadSurface surface = pad_surface(body.mesh, pad);
  const Vec3 way = x.normalized();
  double pulling = 0, all = 0;
  for (const PadFacet& facet : surface.facets) {
    std::array<Vec3, 3> rest, moved;
    for (std::size_t i = 0; i < 3; ++i) {
      rest[i] = body.mesh.nodes[facet.corners[i]];
      moved[i] = Eigen::Map<const Vec3>(&displacements[3 * std::size_t{facet.corners[i]}]);
    }
    const Vec3 area = 0.5 * (rest[1] - rest[0]).cross(rest[2] - rest[0]);
    const double tau = std::clamp(2 * area.normalized().dot(surface.normal), 0.0, 1.0);
    const double weight = area.norm() * tau * tau * (3 - 2 * tau);  // springs by area, but for constants
    over_parts([&](const Vec3& l) {
      const Vec3 y = l[0] * rest[0] + l[1] * rest[1] + l[2] * rest[2];
      const Vec3 u = l[0] * moved[0] + l[1] * moved[1] + l[2] * moved[2];
      const double fall = std::max(0.0, 1 - (y - pad.site).squaredNorm() / (pad.radius * pad.radius));
      const double q = weight * fall * fall * (x - u).dot(way);
      pulling += std::max(0.0, -q);
      all += std::abs(q);
    });
  }
  return all > 0 ? pulling / all : 0;
}

}  // namespace forefeel
