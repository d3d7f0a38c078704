#include "geometry/mesh/tet_faces.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

#include "geometry/common/union_find.hpp"

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

}  // namespace forefeel
