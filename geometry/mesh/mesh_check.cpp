// check_and_orient() of tet_mesh.hpp.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "geometry/common/error.hpp"
#include "geometry/mesh/tet_faces.hpp"

namespace forefeel {
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
