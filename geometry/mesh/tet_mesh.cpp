#include "geometry/mesh/tet_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/common/union_find.hpp"
#include "geometry/mesh/tet_faces.hpp"

namespace forefeel {
namespace {

// Largest and smallest dihedral angle of one tetrahedron [deg].
std::pair<double, double> dihedral_range(const TetMesh& mesh, const Tet& tet) {
  Vec3 normal[4];
  for (int i = 0; i < 4; ++i) {
    const Vec3 &a = mesh.nodes[tet[tet_faces[i][0]]], &b = mesh.nodes[tet[tet_faces[i][1]]],
               &c = mesh.nodes[tet[tet_faces[i][2]]];
    normal[i] = (b - a).cross(c - a);
  }
  double low = 180, high = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      // atan2 keeps its digits near 0 and 180 degrees, where acos loses half of them.
      const double angle =
          std::atan2(normal[i].cross(normal[j]).norm(), -normal[i].dot(normal[j])) * 180 / std::numbers::pi;
      low = std::min(low, angle), high = std::max(high, angle);
    }
  return {low, high};
}

}  // namespace

std::vector<TetFace> sorted_faces(const TetMesh& mesh) {
  std::vector<TetFace> result;
  result.reserve(4 * mesh.tets.size());
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t)
    for (std::uint8_t side = 0; side < 4; ++side) {
      Triangle f;
      for (unsigned k = 0; k < 3; ++k) f[k] = mesh.tets[t][tet_faces[side][k]];
      bool even = true;
      if (f[0] > f[1]) std::swap(f[0], f[1]), even = !even;
      if (f[1] > f[2]) std::swap(f[1], f[2]), even = !even;
      if (f[0] > f[1]) std::swap(f[0], f[1]), even = !even;
      result.push_back({f, t, side, even});
    }
  std::ranges::sort(result, [](const TetFace& a, const TetFace& b) {
    return std::tie(a.sorted, a.tet, a.side) < std::tie(b.sorted, b.tet, b.side);
  });
  return result;
}

double tet_volume(const TetMesh& mesh, std::size_t tet) {
  const auto& [a, b, c, d] = mesh.tets[tet];
  const Vec3& origin = mesh.nodes[a];
  return (mesh.nodes[b] - origin).cross(mesh.nodes[c] - origin).dot(mesh.nodes[d] - origin) / 6;
}

MeshQuality mesh_quality(const TetMesh& mesh) {
  MeshQuality result;
  if (mesh.tets.empty()) return result;
  result.min_dihedral_deg = 180;
  result.min_tet_volume = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const double volume = tet_volume(mesh, t);
    const auto [low, high] = dihedral_range(mesh, mesh.tets[t]);
    result.volume += volume;
    result.min_tet_volume = std::min(result.min_tet_volume, volume);
    result.min_dihedral_deg = std::min(result.min_dihedral_deg, low);
    result.max_dihedral_deg = std::max(result.max_dihedral_deg, high);
  }
  return result;
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

std::vector<Triangle> boundary_triangles(const TetMesh& mesh) {
  const std::vector<TetFace> all = sorted_faces(mesh);
  std::vector<std::pair<std::uint32_t, std::uint8_t>> outer;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i + 1;
    while (end < all.size() && all[end].sorted == all[i].sorted) ++end;
    if (end == i + 1) outer.emplace_back(all[i].tet, all[i].side);
    i = end;
  }
  std::ranges::sort(outer);
  std::vector<Triangle> result;
  result.reserve(outer.size());
  for (const auto& [tet, side] : outer) {
    const Tet& nodes = mesh.tets[tet];
    result.push_back({nodes[tet_faces[side][0]], nodes[tet_faces[side][1]], nodes[tet_faces[side][2]]});
  }
  return result;
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

std::vector<int> face_parts(const TetMesh& mesh) {
  const std::vector<TetFace> all = sorted_faces(mesh);
  UnionFind sets(mesh.tets.size());
  for (std::size_t i = 1; i < all.size(); ++i)
    if (all[i].sorted == all[i - 1].sorted) sets.join(all[i - 1].tet, all[i].tet);
  std::vector<int> number(mesh.tets.size(), -1), result(mesh.tets.size());
  int next = 0;
  for (std::uint32_t t = 0; t < result.size(); ++t) {
    int& root = number[sets.find(t)];
    if (root < 0) root = next++;
    result[t] = root;
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
