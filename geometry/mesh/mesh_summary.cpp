#include "geometry/mesh/mesh_summary.hpp"

#include <algorithm>
#include <vector>

namespace forefeel {

MeshSummary summarise(const TetMesh& mesh) {
  const std::vector<int> part = components(mesh);
  MeshSummary sum{.nodes = static_cast<std::size_t>(std::ranges::count(used_nodes(mesh), 1)),
                  .elements = mesh.tets.size(),
                  .quality = mesh_quality(mesh),
                  .box = bounding_box(mesh),
                  .components = 1 + *std::ranges::max_element(part),
                  .surface_nodes = surface_nodes(mesh).size(),
                  .surface_triangles = boundary_triangles(mesh).size(),
                  .groups = {}};
  for (const auto& [name, nodes] : mesh.groups) sum.groups[name] = nodes.size();
  for (const auto& [name, tets] : mesh.element_groups) {
    MeshSummary::Region region{.name = name, .elements = tets.size()};
    for (const TetIndex tet : tets) region.volume += tet_volume(mesh, static_cast<std::size_t>(tet));
    sum.regions.push_back(region);
  }
  return sum;
}

}  // namespace forefeel
