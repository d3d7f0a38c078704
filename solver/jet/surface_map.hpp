#pragma once
// The rest surface of a body as a place to touch: the smooth surface over its facets (smooth_surface.hpp), which of
// them are clamped, the nearest place to a point, and walks that cross from facet to facet.
//
// A place is a point of the smooth surface over a facet. A facet is clamped if all its corners are; no site is there. A
// walk goes straight on a facet; at a kept edge it turns with the surface, about the edge, and it ends where a clamped
// facet begins.

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "solver/body/body.hpp"
#include "solver/jet/smooth_surface.hpp"

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
  const SmoothSurface& smooth() const { return smooth_; }
  SurfacePlace place(std::int32_t facet, const Vec3& share) const;
  // Where on its facet, in barycentric coordinates; of a point beside the surface, of that under it.
  Vec3 barycentric(const SurfacePlace& place) const;
  SmoothSpot spot(const SurfacePlace& place) const { return smooth_.at(place.facet, barycentric(place)); }
  // Of the three barycentric coordinates in the plane of a facet [1/m].
  std::array<Vec3, 3> flat_slopes(std::int32_t facet) const;
  // Where a place is on its facet.
  struct OnFacet {
    Vec3 share = Vec3::Zero();  // barycentric
    std::array<Vec3, 3> by{Vec3::Zero(), Vec3::Zero(),
                           Vec3::Zero()};  // of them, by a way over the smooth surface [1/m]
    Vec3 normal = Vec3::Zero();            // of the smooth surface
  };
  OnFacet on_facet(const SurfacePlace& place) const;
  double free_area() const { return free_area_; }  // of the facets that are not clamped [m^2]

  SurfacePlace nearest(const Vec3& point) const;  // clamped facets too; O(facets)
  // The foot of a point near a place of a facet, on the smooth surface about it.
  SurfacePlace foot_near(const SurfacePlace& on_facet, const Vec3& point) const;
  SurfacePlace random(std::mt19937_64& random) const;  // uniform by area, not clamped
  // Of the body at rest under a place, against `normal`: to where the way leaves it first [m]; infinite where that goes
  // out at once, as beside a sharp rim. O(facets).
  double thickness(const SurfacePlace& place, const Vec3& normal) const;

  struct Walk {
    SurfacePlace end;
    Vec3 step =
        Vec3::Zero();   // the part of the way that was gone, turned into the tangent plane at the end [m]
    bool whole = true;  // false: ended at a clamped facet or an open edge
    SmoothSpot spot;    // at the end
  };
  // step [m]: only its part in the tangent plane counts. Its length over the surface is that of a short way.
  Walk walk(const SurfacePlace& from, const Vec3& step) const { return walk(from, spot(from), step); }
  Walk walk(const SurfacePlace& from, const SmoothSpot& spot, const Vec3& step) const;

 private:
  // Of the point's foot on the plane of a facet, barycentric.
  Vec3 foot_share(std::int32_t facet, const Vec3& at) const;

  const TetMesh mesh_;
  std::vector<Facet> facets_;
  std::vector<double> sums_;  // of the areas that are not clamped
  double free_area_ = 0;
  SmoothSurface smooth_;
};

}  // namespace forefeel
