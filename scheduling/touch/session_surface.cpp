#include "scheduling/touch/session_surface.hpp"

#include <utility>

namespace forefeel {

SessionSurface::SessionSurface(const RestSites& sites, const SurfaceGrid& grid, double depth, DrawPlaces draw)
    : sites_(sites), grid_(grid), depth_(depth), draw_(std::move(draw)) {}

SurfacePoint SessionSurface::point(const SurfacePlace& place) const {
  const Vec3 normal = sites_.pad().normal(place);
  return {.at = place.at,
          .normal = normal.norm() > 0.5 ? normal : sites_.map().facet(place).normal,
          .facet = place.facet};
}

std::vector<SurfacePoint> SessionSurface::points(const std::string& part, std::size_t count,
                                                 std::uint64_t seed) const {
  std::vector<SurfacePoint> points;
  for (const SurfacePlace& place : draw_(part, count, seed)) points.push_back(point(place));
  return points;
}

SurfacePoint SessionSurface::nearest(const Vec3& at) const {
  return point(sites_.map().nearest(at));
}

SurfacePoint SessionSurface::walked(const SurfacePoint& from, Vec3& step) const {
  const SurfaceMap::Walk walk = sites_.map().walk({from.facet, from.at}, step);
  step = walk.step;
  return point(walk.end);
}

Box SessionSurface::box() const {
  Box box{Vec3::Constant(1e300), Vec3::Constant(-1e300)};
  for (std::size_t f = 0; f < sites_.map().facets().size(); ++f)
    for (const Vec3& corner : sites_.map().corners(static_cast<std::int32_t>(f)))
      box.low = box.low.cwiseMin(corner), box.high = box.high.cwiseMax(corner);
  return box;
}

}  // namespace forefeel
