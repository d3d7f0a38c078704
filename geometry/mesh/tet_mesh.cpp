#include "geometry/mesh/tet_mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/common/error.hpp"
#include "geometry/common/union_find.hpp"

namespace forefeel {
namespace {

// Faces of a positively oriented tetrahedron, each counter-clockwise seen from outside; face i is opposite
// node i.
constexpr unsigned faces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

struct Face {
  Triangle sorted;  // key
  std::uint32_t tet;
  std::uint8_t side;
  bool even;  // parity of the outward order against the sorted one
};

std::vector<Face> sorted_faces(const TetMesh& mesh) {
  std::vector<Face> result;
  result.reserve(4 * mesh.tets.size());
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t)
    for (std::uint8_t side = 0; side < 4; ++side) {
      Triangle f;
      for (unsigned k = 0; k < 3; ++k) f[k] = mesh.tets[t][faces[side][k]];
      bool even = true;
      if (f[0] > f[1]) std::swap(f[0], f[1]), even = !even;
      if (f[1] > f[2]) std::swap(f[1], f[2]), even = !even;
      if (f[0] > f[1]) std::swap(f[0], f[1]), even = !even;
      result.push_back({f, t, side, even});
    }
  std::ranges::sort(result, [](const Face& a, const Face& b) {
    return std::tie(a.sorted, a.tet, a.side) < std::tie(b.sorted, b.tet, b.side);
  });
  return result;
}

// Largest and smallest dihedral angle of one tetrahedron [deg].
std::pair<double, double> dihedral_range(const TetMesh& mesh, const Tet& tet) {
  Vec3 normal[4];
  for (int i = 0; i < 4; ++i) {
    const Vec3 &a = mesh.nodes[tet[faces[i][0]]], &b = mesh.nodes[tet[faces[i][1]]],
               &c = mesh.nodes[tet[faces[i][2]]];
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

void check_indices(const TetMesh& mesh, const std::string& where) {
  if (mesh.tets.empty())
    throw InputError({.file = where}, "holds no tetrahedra, expected a tetrahedral mesh");
  const auto n = static_cast<NodeIndex>(mesh.nodes.size());
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    if (!mesh.nodes[i].allFinite())
      throw InputError({.file = where},
                       fmt::format("node {} (from 0) has a coordinate that is not finite", i));
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (const NodeIndex node : mesh.tets[t])
      if (node >= n)
        throw InputError({.file = where},
                         fmt::format("tetrahedron {} (from 0) names node {}, expected 0 to {}", t,
                                     std::int32_t(node), n - 1));
}

// In a conforming mesh every inner face is seen once from each side.
void check_conforming(const TetMesh& mesh, const std::string& where) {
  const std::vector<Face> all = sorted_faces(mesh);
  for (std::size_t i = 1; i < all.size(); ++i)
    if (all[i].sorted == all[i - 1].sorted && all[i].even == all[i - 1].even)
      throw InputError(
          {.file = where},
          fmt::format("tetrahedra {} and {} (from 0) overlap: they lie on the same side of a shared face",
                      all[i - 1].tet, all[i].tet));
}

}  // namespace

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
  if (mesh.nodes.empty()) return {};
  Box box{mesh.nodes.front(), mesh.nodes.front()};
  for (const Vec3& node : mesh.nodes) box.low = box.low.cwiseMin(node), box.high = box.high.cwiseMax(node);
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
  const std::vector<Face> all = sorted_faces(mesh);
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
    result.push_back({nodes[faces[side][0]], nodes[faces[side][1]], nodes[faces[side][2]]});
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

std::vector<int> components(const TetMesh& mesh) {
  UnionFind sets(mesh.nodes.size());
  std::vector<char> used(mesh.nodes.size(), 0);
  for (const Tet& tet : mesh.tets)
    for (const NodeIndex node : tet)
      used[node] = 1, sets.join(static_cast<std::uint32_t>(tet[0]), static_cast<std::uint32_t>(node));
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

MeshCheck check_and_orient(TetMesh& mesh, const std::string& where) {
  check_indices(mesh, where);
  const double side = longest_side(mesh), smallest = 1e-14 * side * side * side;
  std::size_t positive = 0, first_negative = 0, first_positive = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const double volume = tet_volume(mesh, t);
    if (!(std::abs(volume) >= smallest) || volume == 0)
      throw InputError({.file = where}, fmt::format("tetrahedron {} (from 0, nodes {}) has zero volume", t,
                                                    fmt::join(mesh.tets[t], " ")));
    if (volume > 0 && positive++ == 0) first_positive = t;
    if (volume < 0 && t == positive) first_negative = t;
  }
  MeshCheck result;
  if (positive == 0) {
    for (Tet& tet : mesh.tets) std::swap(tet[2], tet[3]);
    result.warnings.push_back("all tetrahedra were turned: their nodes were listed with negative volume");
  } else if (positive != mesh.tets.size()) {
    throw InputError(
        {.file = where},
        fmt::format("mixed orientation: {} of {} tetrahedra have negative volume (tetrahedron {} has, {} "
                    "has not, from 0), expected all alike",
                    mesh.tets.size() - positive, mesh.tets.size(), first_negative, first_positive));
  }
  check_conforming(mesh, where);
  const std::vector<int> part = components(mesh);
  if (const auto unused = std::ranges::count(part, -1); unused > 0)
    result.warnings.push_back(
        fmt::format("{} node{} to no tetrahedron", unused, unused == 1 ? " belongs" : "s belong"));
  if (const int last = *std::ranges::max_element(part); last > 0)
    result.warnings.push_back(fmt::format("the mesh has {} parts that do not hang together", last + 1));
  return result;
}

std::vector<NodeIndex> nodes_below(const TetMesh& mesh, Axis axis, double share) {
  const Box box = bounding_box(mesh);
  const auto k = static_cast<Eigen::Index>(axis);
  // Nodes on the plane belong to it, whatever rounding left of a scaled body.
  const double limit = box.low[k] + (share + 1e-9) * (box.high[k] - box.low[k]);
  std::vector<NodeIndex> result;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    if (mesh.nodes[i][k] <= limit) result.push_back(static_cast<NodeIndex>(i));
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
