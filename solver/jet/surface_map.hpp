#pragma once
// The rest surface of a body as a place to touch: its facets, which of them are clamped, the nearest place to a point,
// and walks that cross from facet to facet.
//
// A place is a point on a facet. A facet is clamped if all its corners are; no site is there. A walk goes straight on a
// facet; at an edge it turns with the surface, about the edge (a geodesic unless it meets a corner), and ends where a
// clamped facet begins.

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "solver/body/body.hpp"

namespace forefeel {

class SurfaceMap {
 public:
  struct Facet {
    Triangle corners;
    std::array<std::int32_t, 3> beside{-1, -1, -1};  // across the edges 01, 12, 20; -1: none, or several
    Vec3 normal = Vec3::Zero();                      // outward, of length 1
    double area = 0;                                 // [m^2]
    bool clamped = false;
  };

  explicit SurfaceMap(const Body& body);

  const std::vector<Facet>& facets() const { return facets_; }
  const Facet& facet(const SurfacePlace& place) const {
    return facets_[static_cast<std::size_t>(place.facet)];
  }
  std::array<Vec3, 3> corners(std::int32_t facet) const;
  Vec3 barycentric(const SurfacePlace& place) const;
  double free_area() const { return free_area_; }  // of the facets that are not clamped [m^2]

  SurfacePlace nearest(const Vec3& point) const;  // clamped facets too; O(facets)
  bool inside(const Vec3& point) const;           // of the body at rest, by the solid angle of its surface
  SurfacePlace random(std::mt19937_64& random) const;  // uniform by area, not clamped
  // Of the body at rest under a place, against `normal`: to where the way leaves it first [m]; infinite where that goes
  // out at once, as beside a sharp rim. O(facets).
  double thickness(const SurfacePlace& place, const Vec3& normal) const;

  struct Walk {
    SurfacePlace end;
    Vec3 step =
        Vec3::Zero();   // the part of the way that was gone, turned into the plane of the last facet [m]
    bool whole = true;  // false: ended at a clamped facet or an open edge
  };
  // step [m]: only its part in the facet's plane counts.
  Walk walk(const SurfacePlace& from, const Vec3& step) const;

 private:
  const TetMesh mesh_;
  std::vector<Facet> facets_;
  std::vector<double> sums_;  // of the areas that are not clamped
  double free_area_ = 0;
};

}  // namespace forefeel
