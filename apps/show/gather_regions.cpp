#include "apps/show/gather_regions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "solver/body/law_table.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_regions = 200;  // of more, the others count as the rest

using RegionOf = std::vector<std::uint8_t>;  // #T: 0 the rest, k: region k - 1
using Face = std::array<NodeIndex, 3>;       // sorted

Face sorted(Face face) {
  std::ranges::sort(face);
  return face;
}

// The faces of a tetrahedron, seen from outside counter-clockwise.
std::array<Triangle, 4> faces_of(const Tet& t) {
  return {{{t[0], t[2], t[1]}, {t[0], t[1], t[3]}, {t[1], t[2], t[3]}, {t[0], t[3], t[2]}}};
}

// The tetrahedra at each face; the second may be no_tet.
std::map<Face, std::array<TetIndex, 2>> sides_of(const TetMesh& mesh) {
  std::map<Face, std::array<TetIndex, 2>> sides;
  for (TetIndex t = 0; t < mesh.tets.size(); ++t)
    for (const Triangle& face : faces_of(mesh.tets[t])) {
      const auto [found, fresh] = sides.try_emplace(sorted(face), std::array{t, no_tet});
      if (!fresh) found->second[1] = t;
    }
  return sides;
}

// Where two regions touch, the one of fewer elements owns the faces: a tumour is seen in its own colour.
void take_interface(const TetMesh& mesh, const RegionOf& of, ShownInterface& inside) {
  std::vector<NodeIndex> place(mesh.nodes.size(), no_node);
  std::array<std::size_t, 256> elements{};
  for (const std::uint8_t region : of) ++elements[region];
  const auto is_inner = [&](std::uint8_t mine, std::uint8_t theirs) {
    return std::pair(elements[mine], mine) < std::pair(elements[theirs], theirs);
  };
  const auto sides = sides_of(mesh);
  for (TetIndex t = 0; t < mesh.tets.size(); ++t)
    for (const Triangle& face : faces_of(mesh.tets[t])) {
      const auto [a, b] = sides.at(sorted(face));
      const TetIndex other = a == t ? b : a;
      if (other == no_tet) continue;
      const std::uint8_t mine = of[t], theirs = of[other];
      if (mine == 0 || mine == theirs || (theirs > 0 && !is_inner(mine, theirs))) continue;
      Triangle own{};
      for (std::size_t i = 0; i < 3; ++i) {
        NodeIndex& at = place[face[i]];
        if (at == no_node) {
          at = static_cast<NodeIndex>(inside.nodes.size());
          inside.nodes.push_back(mesh.nodes[face[i]]);
        }
        own[i] = at;
      }
      inside.triangles.push_back(own);
      inside.region.push_back(static_cast<std::uint8_t>(mine - 1));
    }
}

void take(const TetMesh& mesh, const RegionOf& of, ShownBody& shown) {
  if (shown.regions.all.empty()) return;
  shown.regions.of_tet = of;
  for (std::size_t t = 0; t < of.size(); ++t)
    if (of[t] > 0) shown.regions.all[of[t] - 1u].volume += tet_volume(mesh, t);
  const auto sides = sides_of(mesh);
  for (const Triangle& face : shown.triangles) {
    Face own{};
    for (std::size_t i = 0; i < 3; ++i) own[i] = shown.node[face[i]];
    shown.regions.of_triangle.push_back(of[static_cast<std::size_t>(sides.at(sorted(own))[0])]);
  }
  take_interface(mesh, of, shown.regions.inside);
}

// Marks the tetrahedra that no region has yet; their number.
std::size_t mark(const std::vector<TetIndex>& tets, std::size_t region, RegionOf& of) {
  std::size_t taken = 0;
  for (const TetIndex t : tets) {
    std::uint8_t& its = of[t];
    if (its > 0) continue;
    its = static_cast<std::uint8_t>(region + 1);
    ++taken;
  }
  return taken;
}

std::string in_words(const Material& material) {
  return fmt::format("{}, {:.3g} kPa", name(material.law), 1e-3 * material.young);
}

}  // namespace

void take_regions(const Body& body, ShownBody& shown) {
  RegionOf of(body.mesh.tets.size(), 0);
  for (const MaterialRegion& region : body.regions) {
    if (shown.regions.all.size() == most_regions) break;
    mark(region.tets, shown.regions.all.size(), of);
    shown.regions.all.push_back({.name = region.name, .words = in_words(region.material)});
  }
  if (!shown.regions.all.empty() && std::ranges::find(of, 0) != of.end())
    shown.regions.rest_words = in_words(body.material);
  take(body.mesh, of, shown);
}

void take_regions(const TetMesh& mesh, ShownBody& shown) {
  RegionOf of(mesh.tets.size(), 0);
  for (const auto& [name, tets] : mesh.element_groups) {
    if (shown.regions.all.size() == most_regions) break;
    if (tets.size() == mesh.tets.size()) continue;
    if (mark(tets, shown.regions.all.size(), of) > 0)
      shown.regions.all.push_back({.name = name, .words = ""});
  }
  take(mesh, of, shown);
}

}  // namespace forefeel
