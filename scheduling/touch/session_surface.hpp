#pragma once
// The surface of a body for paths of the hand (motion/touch_surface.hpp).

#include <functional>

#include "scheduling/motion/touch_surface.hpp"
#include "solver/jet/site_field.hpp"
#include "solver/jet/surface_grid.hpp"

namespace forefeel {

// Places drawn by area from a part of the surface, without those whose pad reaches over the clamp. InputError if the
// part is not one, or holds no such place.
using DrawPlaces =
    std::function<std::vector<SurfacePlace>(const std::string& part, std::size_t count, std::uint64_t seed)>;

class SessionSurface final : public TouchSurface {
 public:
  // Sites and grid must outlive this.
  SessionSurface(const RestSites& sites, const SurfaceGrid& grid, double depth, DrawPlaces draw);
  std::vector<SurfacePoint> points(const std::string& part, std::size_t count,
                                   std::uint64_t seed) const override;
  SurfacePoint nearest(const Vec3& at) const override;
  SurfacePoint walked(const SurfacePoint& from, Vec3& step) const override;
  bool inside(const Vec3& at) const override { return grid_.inside(at); }
  Box box() const override;
  double depth() const override { return depth_; }

 private:
  SurfacePoint point(const SurfacePlace& place) const;

  const RestSites& sites_;
  const SurfaceGrid& grid_;
  double depth_;
  DrawPlaces draw_;
};

}  // namespace forefeel
