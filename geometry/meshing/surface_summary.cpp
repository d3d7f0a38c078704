#include "geometry/meshing/surface_summary.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace forefeel {

SurfaceSummary summarise(const Surface& surface) {
  std::map<std::pair<NodeIndex, NodeIndex>, int> edges;
  for (const Triangle& t : surface.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
  SurfaceSummary sum{.nodes = surface.nodes.size(),
                     .triangles = surface.triangles.size(),
                     .border_edges = 0,
                     .non_manifold_edges = 0,
                     .volume = std::numeric_limits<double>::quiet_NaN(),
                     .box = bounding_box(surface)};
  for (const auto& [edge, triangles] : edges) {
    sum.border_edges += triangles == 1;
    sum.non_manifold_edges += triangles > 2;
  }
  if (sum.closed()) sum.volume = enclosed_volume(surface);
  return sum;
}

}  // namespace forefeel
