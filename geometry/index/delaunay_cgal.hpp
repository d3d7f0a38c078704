#pragma once
// The Delaunay triangulation of CGAL with predicates of our own, and measures of its cells: barycentric
// weights, circumcentre, distance above a facet of the hull. Lengths in [m]. Private to delaunay_index.cpp,
// which alone includes it: CGAL needs that file's compiler flags, and everything here has internal linkage.

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "geometry/common/types.hpp"
#include "geometry/index/integer_predicates.hpp"

namespace forefeel {
namespace {

// CGAL's exact predicates, with the signs that rounding leaves open decided on integers where the points
// allow it.
struct Kernel : CGAL::Exact_predicates_inexact_constructions_kernel {
  using Exact = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Point = Exact::Point_3;
  static std::array<double, 3> coordinates(const Point& p) { return {p.x(), p.y(), p.z()}; }

  struct Orientation_3 : Exact::Orientation_3 {
    using Exact::Orientation_3::operator();
    CGAL::Orientation operator()(const Point& p, const Point& q, const Point& r, const Point& s) const {
      const Vec3 a(q.x() - p.x(), q.y() - p.y(), q.z() - p.z()),
          b(r.x() - p.x(), r.y() - p.y(), r.z() - p.z()), c(s.x() - p.x(), s.y() - p.y(), s.z() - p.z());
      const double volume = a.dot(b.cross(c));
      // Six products of three differences, each rounded by at most 9 units in the last place with those of
      // the sums.
      const double bound =
          1e-14 * a.cwiseAbs().maxCoeff() * b.cwiseAbs().maxCoeff() * c.cwiseAbs().maxCoeff();
      if (std::abs(volume) > bound && bound > 1e-250) return volume > 0 ? CGAL::POSITIVE : CGAL::NEGATIVE;
      const GridPoints<4> grid({coordinates(p), coordinates(q), coordinates(r), coordinates(s)});
      if (!grid.exact()) return Exact::Orientation_3()(p, q, r, s);
      return static_cast<CGAL::Orientation>(orientation_sign(grid(1, 0), grid(2, 0), grid(3, 0)));
    }
  };
  Orientation_3 orientation_3_object() const { return {}; }

  struct Side_of_oriented_sphere_3 : Exact::Side_of_oriented_sphere_3 {
    CGAL::Oriented_side operator()(const Point& p, const Point& q, const Point& r, const Point& s,
                                   const Point& t) const {
      const Vec3 o = vec(t), a = vec(p) - o, b = vec(r) - o, c = vec(q) - o, d = vec(s) - o;
      const double aa = a.squaredNorm(), bb = b.squaredNorm(), cc = c.squaredNorm(), dd = d.squaredNorm();
      const Vec3 ab = a.cross(b), cd = c.cross(d);
      const double sum = dd * ab.dot(c) - cc * ab.dot(d) + bb * cd.dot(a) - aa * cd.dot(b);
      const Vec3 most = a.cwiseAbs().cwiseMax(b.cwiseAbs()).cwiseMax(c.cwiseAbs()).cwiseMax(d.cwiseAbs());
      // 24 products, each at most this one, rounded by at most 24 units in the last place with those of the
      // sums.
      const double bound = 1.5e-13 * most.prod() * std::max({aa, bb, cc, dd});
      if (std::abs(sum) > bound && bound > 1e-250)
        return sum > 0 ? CGAL::ON_POSITIVE_SIDE : CGAL::ON_NEGATIVE_SIDE;
      const GridPoints<5> grid(
          {coordinates(p), coordinates(q), coordinates(r), coordinates(s), coordinates(t)});
      if (!grid.exact()) return Exact::Side_of_oriented_sphere_3()(p, q, r, s, t);
      return static_cast<CGAL::Oriented_side>(sphere_sign(grid(0, 4), grid(2, 4), grid(1, 4), grid(3, 4)));
    }
  };
  Side_of_oriented_sphere_3 side_of_oriented_sphere_3_object() const { return {}; }

  static Vec3 vec(const Point& p) { return {p.x(), p.y(), p.z()}; }
};

}  // namespace
}  // namespace forefeel

template <>
struct CGAL::Triangulation_structural_filtering_traits<
    forefeel::Kernel> {  // as for the kernel it derives from
  using Use_structural_filtering_tag = CGAL::Tag_true;
};

namespace forefeel {
namespace {

using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;
using Tds =
    CGAL::Triangulation_data_structure_3<VertexBase, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, Tds>;
using Point = Kernel::Point_3;
using CellHandle = Delaunay::Cell_handle;
using VertexHandle = Delaunay::Vertex_handle;

constexpr double flat = 1e-7;         // relative height of cells whose circumcentre rounding decides
constexpr double thin = 1e-12;        // relative height of cells that count as coplanar
constexpr double on_face = 1e-9;      // weights below are zero: q lies on a facet, edge or vertex
constexpr double rounding = 0x1p-52;  // of a coordinate

Vec3 vec(const Point& p) {
  return {p.x(), p.y(), p.z()};
}
Point point(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

// Corners relative to q, and the barycentric weights of q.
struct Simplex {
  std::array<Vec3, 4> at;
  std::array<double, 4> weight;
  double lowest = 0;

  // False where the cell is lower than `height` [m] or `thin`: its weights would be rounding.
  bool set(CellHandle cell, const Vec3& q, double height) {
    for (int i = 0; i < 4; ++i) at[static_cast<std::size_t>(i)] = vec(cell->vertex(i)->point()) - q;
    const Vec3 a = at[1] - at[0], b = at[2] - at[0], c = at[3] - at[0];
    const double volume = a.dot(b.cross(c));
    const double squared = std::max({a.squaredNorm(), b.squaredNorm(), c.squaredNorm()}),
                 longest = std::sqrt(squared);
    if (volume <= (thin * longest + height) * squared) return false;
    if (volume > 1e-5 * squared * longest) {
      const Vec3 bc = at[2].cross(at[3]), ab = at[0].cross(at[1]);
      weight = {at[1].dot(bc) / volume, -at[0].dot(bc) / volume, at[3].dot(ab) / volume,
                -at[2].dot(ab) / volume};
    } else {
      set_exactly(cell, q);
    }
    lowest = std::min({weight[0], weight[1], weight[2], weight[3]});
    return true;
  }
  // In a thin cell even the rounding of coordinate differences is too large.
  void set_exactly(CellHandle cell, const Vec3& q) {
    using Long3 = Eigen::Matrix<long double, 3, 1>;
    std::array<Long3, 4> p;
    for (int i = 0; i < 4; ++i)
      p[static_cast<std::size_t>(i)] =
          vec(cell->vertex(i)->point()).cast<long double>() - q.cast<long double>();
    const Long3 bc = p[2].cross(p[3]), ab = p[0].cross(p[1]);
    const std::array<long double, 4> part{p[1].dot(bc), -p[0].dot(bc), p[3].dot(ab), -p[2].dot(ab)};
    const long double whole = part[0] + part[1] + part[2] + part[3];
    for (std::size_t i = 0; i < 4; ++i) weight[i] = static_cast<double>(part[i] / whole);
  }
  void clamp() {
    double sum = 0;
    for (double& w : weight) sum += w = std::max(w, 0.0);
    for (double& w : weight) w /= sum;
  }
  double spread() const {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += weight[i] * at[i].squaredNorm();
    return std::sqrt(sum);
  }
};

// A place well inside the hull of the states, updated as states are added: the mean of the states that are
// farthest along 26 directions.
class Inside {
 public:
  Inside() {
    for (int k = 0; k < 13; ++k)
      direction_[static_cast<std::size_t>(k)] = Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
    for (std::size_t i = 0; i < 13; ++i)
      low_[i] = std::numeric_limits<double>::infinity(), high_[i] = -low_[i];
  }
  void add(const Vec3& p) {
    bool changed = false;
    for (std::size_t i = 0; i < 13; ++i) {
      const double along = direction_[i].dot(p);
      if (along < low_[i]) low_[i] = along, first_[i] = p, changed = true;
      if (along > high_[i]) high_[i] = along, last_[i] = p, changed = true;
    }
    if (!changed) return;
    largest_ = std::max(largest_, p.cwiseAbs().maxCoeff());
    mean_ = Vec3::Zero();
    for (std::size_t i = 0; i < 13; ++i) mean_ += (first_[i] + last_[i]) / 26;
  }
  const Vec3& place() const { return mean_; }
  double largest() const { return largest_; }  // coordinate of any state, without sign [m]

 private:
  std::array<Vec3, 13> direction_, first_, last_;
  std::array<double, 13> low_, high_;
  Vec3 mean_ = Vec3::Zero();
  double largest_ = 0;
};

// Circumcentre relative to the first corner; infinite where the cell is flat.
Vec3 circumcentre(CellHandle cell) {
  const Vec3 o = vec(cell->vertex(0)->point());
  const Vec3 a = vec(cell->vertex(1)->point()) - o, b = vec(cell->vertex(2)->point()) - o,
             c = vec(cell->vertex(3)->point()) - o;
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), cc = c.squaredNorm();
  const double volume = a.dot(b.cross(c)), longest = std::max({aa, bb, cc});
  if (volume <= flat * longest * std::sqrt(longest))
    return Vec3::Constant(std::numeric_limits<double>::infinity());
  return (aa * b.cross(c) + bb * c.cross(a) + cc * a.cross(b)) / (2 * volume);
}
double circumradius(CellHandle cell) {
  return circumcentre(cell).norm();
}

// The facet by which q left the hull, for an infinite cell: how far q is above its plane.
struct Exit {
  double longest;  // edge [m]
  double height;   // [m]; 0 where the facet is too thin to have a normal

  Exit(const Delaunay& triangulation, CellHandle cell, const Vec3& q) {
    const int far = cell->index(triangulation.infinite_vertex());
    const Vec3 a = vec(cell->vertex((far + 1) & 3)->point()), b = vec(cell->vertex((far + 2) & 3)->point()),
               c = vec(cell->vertex((far + 3) & 3)->point());
    const Vec3 normal = (b - a).cross(c - a);
    longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()}));
    const double area = normal.norm();
    height = area > 1e-6 * longest * longest ? std::abs(normal.dot(q - a)) / area : 0;
  }
};

}  // namespace
}  // namespace forefeel
