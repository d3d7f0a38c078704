#pragma once
// The surface of a body at rest, as a hand that may touch it anywhere needs it: where paths run, and where a recorded
// motion begins. All in the axes of the mesh [m].

#include <cstddef>
#include <string>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

struct SurfacePoint {
  Vec3 at = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  // outward, mean over the pad
  std::int32_t facet = -1;
};

class TouchSurface {
 public:
  virtual ~TouchSurface() = default;
  // Drawn by area from the part of the surface where a pad does not reach over the clamp; the same seed gives the same
  // points. part: "x/y/z/radius" or a node group; empty: all. InputError if nothing of it is free.
  virtual std::vector<SurfacePoint> points(const std::string& part, std::size_t count,
                                           std::uint64_t seed) const = 0;
  virtual SurfacePoint nearest(const Vec3& at) const = 0;
  // Straight over the facets, bent with them; ends at the clamp. `step` becomes the same direction and length at the
  // end.
  virtual SurfacePoint walked(const SurfacePoint& from, Vec3& step) const = 0;
  virtual bool inside(const Vec3& at) const = 0;
  virtual Box box() const = 0;       // of the body
  virtual double depth() const = 0;  // to which states are placed
};

}  // namespace forefeel
