#include "solver/body/pad.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <map>
#include <numbers>

namespace forefeel {
namespace {

using Vec2 = Eigen::Vector2d;

// Nearest point of a triangle (C. Ericson, Real-Time Collision Detection, 2005, 5.1.5).
Vec3 nearest_in_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  if (d6 >= 0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  return a + (vb * ab + vc * ac) / (va + vb + vc);
}

struct Corners {
  Vec3 a, b, c;
  Vec3 nearest(const Vec3& p) const { return nearest_in_triangle(p, a, b, c); }
  Vec3 area() const { return 0.5 * (b - a).cross(c - a); }
};

Corners corners_of(const TetMesh& mesh, const Triangle& t) {
  return {mesh.nodes[t[0]], mesh.nodes[t[1]], mesh.nodes[t[2]]};
}

// Gauss-Legendre on [0, 1], eight points: exact for polynomials to degree 15.
struct GaussRule {
  std::array<double, 8> at{}, weight{};
};

const GaussRule& gauss_rule() {
  static const GaussRule rule = [] {
    using Gauss = boost::math::quadrature::gauss<double, 8>;
    GaussRule r;
    for (std::size_t i = 0; i < 4; ++i) {
      const double x = Gauss::abscissa()[i], w = 0.5 * Gauss::weights()[i];
      r.at[2 * i] = 0.5 * (1 + x), r.at[2 * i + 1] = 0.5 * (1 - x);
      r.weight[2 * i] = r.weight[2 * i + 1] = w;
    }
    return r;
  }();
  return rule;
}

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Quadrature points over the signed triangle (0, a, b).
template <class Visit>
void over_triangle(const Vec2& a, const Vec2& b, const Visit& visit) {
  const GaussRule& rule = gauss_rule();
  const double twice = cross(a, b);
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t k = 0; k < 8; ++k) {
      const double s = rule.at[i], t = rule.at[k];
      visit(Vec2(s * ((1 - t) * a + t * b)), rule.weight[i] * rule.weight[k] * s * twice);
    }
}

// Over the signed sector of the disc |y| < radius between the directions of a and b, in pieces of at most 45 degrees.
template <class Visit>
void over_sector(const Vec2& a, const Vec2& b, double radius, const Visit& visit) {
  const GaussRule& rule = gauss_rule();
  const double angle = std::atan2(cross(a, b), a.dot(b)), from = std::atan2(a.y(), a.x());
  const int pieces = std::max(1, static_cast<int>(std::ceil(std::abs(angle) / (std::numbers::pi / 4))));
  for (int piece = 0; piece < pieces; ++piece)
    for (std::size_t i = 0; i < 8; ++i)
      for (std::size_t k = 0; k < 8; ++k) {
        const double s = rule.at[i] * radius, turn = from + angle * (piece + rule.at[k]) / pieces;
        visit(Vec2(s * std::cos(turn), s * std::sin(turn)),
              rule.weight[i] * rule.weight[k] * s * radius * angle / pieces);
      }
}

// Triangle ∩ disc |y| < radius, as the signed sum over the edges (a, b) of (0, a, b) ∩ disc: a triangle where the edge
// runs inside the disc, sectors before and after.
template <class Visit>
void over_edge(const Vec2& a, const Vec2& b, double radius, const Visit& visit) {
  const Vec2 way = b - a;
  const double length2 = way.squaredNorm(), half = -a.dot(way) / length2;
  const double distance2 = (a + half * way).squaredNorm(), room = radius * radius - distance2;
  if (room <= 0) return over_sector(a, b, radius, visit);
  const double reach = std::sqrt(room / length2);
  const double enter = std::clamp(half - reach, 0.0, 1.0), leave = std::clamp(half + reach, 0.0, 1.0);
  if (enter >= leave) return over_sector(a, b, radius, visit);
  const Vec2 p = a + enter * way, q = a + leave * way;
  if (enter > 0) over_sector(a, p, radius, visit);
  over_triangle(p, q, visit);
  if (leave < 1) over_sector(q, b, radius, visit);
}

// Shape functions of a facet at barycentric coordinates l.
std::array<double, 6> shapes(const Vec3& l, int nodes) {
  if (nodes == 3) return {l[0], l[1], l[2]};
  return {l[0] * (2 * l[0] - 1), l[1] * (2 * l[1] - 1), l[2] * (2 * l[2] - 1),
          4 * l[0] * l[1],       4 * l[1] * l[2],       4 * l[2] * l[0]};
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

double facing(double cosine) {
  const double tau = std::clamp(2 * cosine, 0.0, 1.0);
  return tau * tau * (3 - 2 * tau);
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
  for (std::size_t t = 0; t < near.size(); ++t) {
    for (std::size_t e = 0; e < 3; ++e) {
      const NodeIndex a = near[t][e], b = near[t][(e + 1) % 3];
      beside[{std::min(a, b), std::max(a, b)}].push_back(t);
    }
    if ((corners_of(mesh, near[t]).nearest(pad.site) - pad.site).norm() <= 1e-7 * pad.radius) take(t);
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

}  // namespace forefeel
