#include "geometry/meshing/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace forefeel {

Surface boundary_surface(const TetMesh& mesh) {
  Surface result;
  std::vector<NodeIndex> number(mesh.nodes.size());
  for (const NodeIndex node : surface_nodes(mesh)) {
    number[node] = static_cast<NodeIndex>(result.nodes.size());
    result.nodes.push_back(mesh.nodes[node]);
  }
  result.triangles = boundary_triangles(mesh);
  for (Triangle& triangle : result.triangles)
    for (NodeIndex& node : triangle) node = number[node];
  return result;
}

double enclosed_volume(const Surface& surface) {
  if (surface.nodes.empty()) return 0;
  double sum = 0;
  const Vec3& origin = surface.nodes.front();
  for (const auto& [a, b, c] : surface.triangles)
    sum += (surface.nodes[a] - origin).cross(surface.nodes[b] - origin).dot(surface.nodes[c] - origin);
  return sum / 6;
}

Box bounding_box(const Surface& surface) {
  if (surface.nodes.empty() || surface.triangles.empty()) return {};
  const Vec3& first = surface.nodes[surface.triangles.front()[0]];
  Box box{first, first};
  for (const Triangle& triangle : surface.triangles)
    for (const NodeIndex node : triangle) {
      box.low = box.low.cwiseMin(surface.nodes[node]);
      box.high = box.high.cwiseMax(surface.nodes[node]);
    }
  return box;
}

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
