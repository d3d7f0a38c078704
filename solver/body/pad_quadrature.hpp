#pragma once
// Integrals of a pad's springs over a facet of the surface within the ball |y - s| < r (pad.hpp): Gauss quadrature over
// triangles where the facet's edge runs inside the ball, and over sectors of the disc elsewhere.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>

#include "geometry/common/types.hpp"

namespace forefeel::pad_quadrature {

using Vec2 = Eigen::Vector2d;

// Nearest point of a triangle (C. Ericson, Real-Time Collision Detection, 2005, 5.1.5).
inline Vec3 nearest_in_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
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

// Gauss-Legendre on [0, 1], eight points: exact for polynomials to degree 15.
struct GaussRule {
  std::array<double, 8> at{}, weight{};
};

inline const GaussRule& gauss_rule() {
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

inline double cross(const Vec2& a, const Vec2& b) {
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
inline std::array<double, 6> shapes(const Vec3& l, int nodes) {
  if (nodes == 3) return {l[0], l[1], l[2]};
  return {l[0] * (2 * l[0] - 1), l[1] * (2 * l[1] - 1), l[2] * (2 * l[2] - 1),
          4 * l[0] * l[1],       4 * l[1] * l[2],       4 * l[2] * l[0]};
}

// g of pad.hpp, and its slope.
inline double facing(double cosine) {
  const double tau = std::clamp(2 * cosine, 0.0, 1.0);
  return tau * tau * (3 - 2 * tau);
}
inline double facing_slope(double cosine) {
  const double tau = std::clamp(2 * cosine, 0.0, 1.0);
  return 12 * tau * (1 - tau);
}

}  // namespace forefeel::pad_quadrature
