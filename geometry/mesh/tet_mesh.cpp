#include "geometry/mesh/tet_mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/common/union_find.hpp"

namespace forefeel {

// ---- faces

namespace {

// Faces of a positively oriented tetrahedron, each counter-clockwise seen from outside; face i is opposite
// node i.
constexpr unsigned tet_faces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

struct TetFace {
  Triangle sorted;  // key
  TetIndex tet;
  std::uint8_t side;
  bool even;  // parity of the outward order against the sorted one
};

// The faces, sorted so that those of two tetrahedra that share three nodes are neighbours.
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

// ---- measures

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

// ---- whether it can be solved

namespace {

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
void check_conforming(const TetMesh& mesh, std::size_t turned, const std::string& where) {
  const std::vector<TetFace> all = sorted_faces(mesh);
  for (std::size_t i = 1; i < all.size(); ++i)
    if (all[i].sorted == all[i - 1].sorted && all[i].even == all[i - 1].even)
      throw InputError(
          {.file = where},
          fmt::format("tetrahedra {} and {} (from 0) overlap: they lie on the same side of a shared face{}",
                      all[i - 1].tet, all[i].tet,
                      turned == 0 ? ""
                                  : fmt::format("; {} of {} tetrahedra have negative volume, so the mesh is "
                                                "probably tangled",
                                                turned, mesh.tets.size())));
}

// Tetrahedra with the same four nodes are one, of all their groups: Gmsh lists an element once for each of its physical
// groups in format 2. Returns how many were listed again without another group.
std::size_t unite_repeated(TetMesh& mesh) {
  std::vector<std::pair<Tet, TetIndex>> keys(mesh.tets.size());
  for (TetIndex t = 0; t < keys.size(); ++t) {
    keys[t] = {mesh.tets[t], t};
    std::ranges::sort(keys[t].first);
  }
  std::ranges::sort(keys);
  constexpr TetIndex kept = no_tet;
  std::vector<TetIndex> same(keys.size(), kept);  // the first of the same nodes
  for (std::size_t i = 1, first = 0; i < keys.size(); ++i) {
    if (keys[i].first != keys[first].first)
      first = i;
    else
      same[keys[i].second] = keys[first].second;
  }
  std::vector<TetIndex> number(keys.size());
  TetIndex next = 0;
  for (TetIndex t = 0; t < number.size(); ++t) number[t] = same[t] == kept ? next++ : number[same[t]];
  if (next == number.size()) return 0;
  std::vector<char> has_other_group(number.size(), 0);
  for (auto& [name, tets] : mesh.element_groups) {
    const std::set<TetIndex> before(tets.begin(), tets.end());
    for (const TetIndex t : tets)
      if (same[t] != kept && !before.contains(same[t])) has_other_group[t] = 1;
    for (TetIndex& t : tets) t = number[t];
    std::ranges::sort(tets);
    tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
  }
  std::size_t plain = 0;
  for (TetIndex t = 0; t < number.size(); ++t) {
    plain += same[t] != kept && !has_other_group[t];
    if (same[t] == kept) mesh.tets[number[t]] = mesh.tets[t];
  }
  mesh.tets.resize(next);
  return plain;
}

// Turns tetrahedra of negative volume; returns how many.
std::size_t turn_negative(TetMesh& mesh, const std::string& where) {
  const double side = longest_side(mesh), smallest = 1e-14 * side * side * side;
  std::size_t turned = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const double volume = tet_volume(mesh, t);
    if (!(std::abs(volume) >= smallest) || volume == 0)
      throw InputError({.file = where}, fmt::format("tetrahedron {} (from 0, nodes {}) has zero volume", t,
                                                    fmt::join(mesh.tets[t], " ")));
    if (volume > 0) continue;
    std::swap(mesh.tets[t][2], mesh.tets[t][3]);
    ++turned;
  }
  return turned;
}

std::string in_words(std::size_t turned, std::size_t all) {
  if (turned == all) return "all tetrahedra were turned: their nodes were listed with negative volume";
  return turned == 1
             ? fmt::format("1 of {} tetrahedra was turned: its nodes were listed with negative volume", all)
             : fmt::format("{} of {} tetrahedra were turned: their nodes were listed with negative volume",
                           turned, all);
}

// Takes nodes of no tetrahedron out of the groups of nodes; returns how many nodes there are.
std::size_t drop_unused(TetMesh& mesh) {
  const std::vector<char> used = used_nodes(mesh);
  for (auto& [name, nodes] : mesh.groups) std::erase_if(nodes, [&](NodeIndex node) { return !used[node]; });
  return static_cast<std::size_t>(std::ranges::count(used, 0));
}

// Those on the edges of second-order tetrahedra that are no corner.
std::size_t middle_nodes(const TetMesh& mesh) {
  const std::vector<char> used = used_nodes(mesh);
  return static_cast<std::size_t>(
      std::ranges::count_if(mesh.second_order.middle_nodes, [&](NodeIndex node) { return !used[node]; }));
}

}  // namespace

MeshCheck check_and_orient(TetMesh& mesh, const std::string& where) {
  check_indices(mesh, where);
  MeshCheck result;
  const std::size_t turned = turn_negative(mesh, where);
  if (const std::size_t repeated = unite_repeated(mesh); repeated > 0)
    result.warnings.push_back(
        fmt::format("{} listed twice with the same nodes and groups: {} once",
                    repeated == 1 ? "1 tetrahedron was" : fmt::format("{} tetrahedra were", repeated),
                    repeated == 1 ? "it counts" : "they count"));
  check_conforming(mesh, turned, where);
  if (turned > 0) result.warnings.push_back(in_words(turned, mesh.tets.size()));
  const std::size_t lonely = drop_unused(mesh), middle = middle_nodes(mesh);
  if (mesh.second_order.bent > 0.01)
    result.warnings.push_back(fmt::format(
        "edges of second-order tetrahedra are straightened: a mid-edge node is {:.1f} % of its edge from the "
        "middle",
        100 * mesh.second_order.bent));
  if (const std::size_t unused = lonely - middle; unused > 0)
    result.warnings.push_back(fmt::format(
        "{} to no tetrahedron and {} no part of the body",
        unused == 1 ? "1 node belongs" : fmt::format("{} nodes belong", unused), unused == 1 ? "is" : "are"));
  const int parts = std::ranges::max(components(mesh)) + 1, by_faces = std::ranges::max(face_parts(mesh)) + 1;
  if (parts > 1)
    result.warnings.push_back(fmt::format("the mesh has {} parts that do not hang together", parts));
  if (by_faces > parts)
    result.warnings.push_back(fmt::format(
        "the mesh has {} parts that hang together by single nodes or edges only, as by a hinge", by_faces));
  return result;
}

}  // namespace forefeel
