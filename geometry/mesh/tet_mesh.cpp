#include "geometry/mesh/tet_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/common/union_find.hpp"

namespace forefeel {
double tet_volume(const TetMesh& mesh, std::size_t tet) {
  const auto& [a, b, c, d] = mesh.tets[tet];
  const Vec3& origin = mesh.nodes[a];
  return (mesh.nodes[b] - origin).cross(mesh.nodes[c] - origin).dot(mesh.nodes[d] - origin) / 6;
}

Box bounding_box(const TetMesh& mesh) {
  if (mesh.nodes.empty() || mesh.tets.empty()) return {};
  const Vec3& first = mesh.nodes[mesh.tets.front()[0]];
  Box box{first, first};
  for (const Tet& tet : mesh.tets)
    for (const NodeIndex node : tet) {
      box.low = box.low.cwiseMin(mesh.nodes[node]);
      box.high = box.high.cwiseMax(mesh.nodes[node]);
    }
  return box;
}

double longest_side(const TetMesh& mesh) {
  return bounding_box(mesh).size().maxCoeff();
}

void scale_to_length(TetMesh& mesh, double length) {
  const double side = longest_side(mesh);
  if (!(side > 0) || !std::isfinite(side)) return;
  for (Vec3& node : mesh.nodes) node *= length / side;
}

std::vector<NodeIndex> surface_nodes(const TetMesh& mesh) {
  std::vector<NodeIndex> result;
  for (const Triangle& triangle : boundary_triangles(mesh))
    result.insert(result.end(), triangle.begin(), triangle.end());
  std::ranges::sort(result);
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

std::vector<char> used_nodes(const TetMesh& mesh) {
  std::vector<char> used(mesh.nodes.size(), 0);
  for (const Tet& tet : mesh.tets)
    for (const NodeIndex node : tet) used[node] = 1;
  return used;
}

std::vector<int> components(const TetMesh& mesh) {
  UnionFind sets(mesh.nodes.size());
  const std::vector<char> used = used_nodes(mesh);
  for (const Tet& tet : mesh.tets)
    for (const NodeIndex node : tet) sets.join(tet[0], node);
  std::vector<int> number(mesh.nodes.size(), -1), result(mesh.nodes.size(), -1);
  int next = 0;
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (!used[i]) continue;
    int& root = number[sets.find(static_cast<std::uint32_t>(i))];
    if (root < 0) root = next++;
    result[i] = root;
  }
  return result;
}

std::vector<NodeIndex> nodes_below(const TetMesh& mesh, Axis axis, double share) {
  const Box box = bounding_box(mesh);
  const auto k = static_cast<Eigen::Index>(axis);
  // Nodes on the plane belong to it, whatever rounding left of a scaled body.
  const double limit = box.low[k] + (share + 1e-9) * (box.high[k] - box.low[k]);
  const std::vector<char> used = used_nodes(mesh);
  std::vector<NodeIndex> result;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    if (used[i] && mesh.nodes[i][k] <= limit) result.push_back(static_cast<NodeIndex>(i));
  return result;
}

NodeIndex nearest_surface_node(const TetMesh& mesh, const Vec3& point) {
  NodeIndex best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (const NodeIndex node : surface_nodes(mesh)) {
    const double distance = (mesh.nodes[node] - point).squaredNorm();
    if (distance < least) least = distance, best = node;
  }
  return best;
}

std::vector<NodeIndex> surface_nodes_within(const TetMesh& mesh, const Vec3& centre, double radius) {
  std::vector<NodeIndex> result = surface_nodes(mesh);
  std::erase_if(result, [&](NodeIndex node) { return (mesh.nodes[node] - centre).norm() > radius; });
  return result;
}

}  // namespace forefeel
