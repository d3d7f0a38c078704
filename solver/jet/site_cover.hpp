#pragma once
// Sites that cover the unclamped surface. The distance of two places counts their normals too:
//   delta^2 = |s - s'|^2 + L^2 |n - n'|^2          [m]
// n the mean normal under the pad and L = pad_lengths times the pad's radius, so sites lie denser where the surface
// bends, and those across a thin lobe are far. Places that are near in space and far along the surface are told apart
// by the distance along the mesh's edges (distances()).
//
// The farthest of many places becomes the next site until all are near (Gonzalez 1985): the first sites are a coarse
// cover already, and at most twice as many as needed.

#include <vector>

#include "solver/jet/moving_pad.hpp"

namespace forefeel {

constexpr double normal_length = 1;  // L over the pad's radius

struct CoverOptions {
  double spacing = 0.008;  // every place has a site within this delta [m]
  std::size_t most_sites = 20000;
  double places_per_site = 40;  // that are looked at; drawn by area
};

// In the order in which they were chosen; the first is the place nearest to `first`.
std::vector<SurfacePlace> cover(const SurfaceMap& map, const MovingPad& pad, const Vec3& first,
                                const CoverOptions& options);

// Along the mesh's edges from a place to the nodes of the surface [m], to `most`: node, distance, ascending by node.
struct NodeDistance {
  NodeIndex node = 0;
  double distance = 0;
};
class EdgeDistances {
 public:
  explicit EdgeDistances(const SurfaceMap& map);
  std::vector<NodeDistance> from(const SurfacePlace& place, double most) const;

 private:
  const SurfaceMap& map_;
  std::vector<std::vector<NodeDistance>> edges_;  // by node
};

}  // namespace forefeel
