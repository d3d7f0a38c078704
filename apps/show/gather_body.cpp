#include "apps/show/gather_body.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "apps/console/console.hpp"
#include "apps/scene/field_check.hpp"
#include "apps/scene/palpation_map.hpp"
#include "apps/scene/scene_body.hpp"
#include "apps/scene/scene_field.hpp"
#include "solver/body/law.hpp"
#include "solver/body/pad.hpp"

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

namespace {

constexpr int most_parts = 64;  // of a side of a facet

// A facet of the surface, and the springs at its points.
struct Facet {
  std::uint32_t number = 0;
  std::array<Vec3, 3> corner;  // [m], as the pad's site
  Vec3 normal;
};

class Splitter {
 public:
  Splitter(const Pad& pad, const PadSurface& surface) : pad_(pad), surface_(surface) {
    out_.peak = pad_peak(pad);
  }

  // The parts of a facet on which springs act.
  void add(const Facet& facet) {
    double longest = 0;
    for (std::size_t i = 0; i < 3; ++i)
      longest = std::max(longest, (facet.corner[i] - facet.corner[(i + 1) % 3]).norm());
    const int n = std::clamp(static_cast<int>(std::ceil(8 * longest / pad_.radius)), 1, most_parts);
    std::map<std::array<int, 2>, NodeIndex> known;
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        add_part(facet, n, {{{i, j}, {i + 1, j}, {i, j + 1}}}, known);
        if (i + j + 1 < n) add_part(facet, n, {{{i + 1, j}, {i + 1, j + 1}, {i, j + 1}}}, known);
      }
  }
  ShownPad take() { return std::move(out_); }

 private:
  using Place = std::array<int, 2>;

  void add_part(const Facet& facet, int n, const std::array<Place, 3>& places,
                std::map<Place, NodeIndex>& known) {
    std::array<Vec3, 3> at;
    std::array<double, 3> weight{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double a = double(places[k][0]) / n, b = double(places[k][1]) / n;
      at[k] = Vec3(1 - a - b, a, b);
      const Vec3 y = at[k][0] * facet.corner[0] + at[k][1] * facet.corner[1] + at[k][2] * facet.corner[2];
      weight[k] = pad_density(pad_, surface_, y, facet.normal) / out_.peak;
    }
    if (weight == std::array<double, 3>{}) return;
    Triangle part{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [found, fresh] = known.try_emplace(places[k], static_cast<NodeIndex>(out_.facet.size()));
      part[k] = found->second;
      if (!fresh) continue;
      out_.facet.push_back(facet.number);
      out_.at.push_back(at[k]);
      out_.weight.push_back(weight[k]);
    }
    out_.triangles.push_back(part);
  }

  const Pad& pad_;
  const PadSurface& surface_;
  ShownPad out_;
};

}  // namespace

std::optional<ShownPad> shown_pad(const Body& body, const ShownBody& shown) {
  if (!body.pad) return {};
  std::map<Triangle, std::uint32_t> number;  // of each triangle of the surface, by its nodes in the mesh
  for (std::size_t t = 0; t < shown.triangles.size(); ++t) {
    const Triangle& own = shown.triangles[t];
    number[{shown.node[own[0]], shown.node[own[1]], shown.node[own[2]]}] = static_cast<std::uint32_t>(t);
  }
  const PadSurface surface = pad_surface(body.mesh, *body.pad);
  Splitter splitter(*body.pad, surface);
  for (const PadFacet& facet : surface.facets) {
    const auto corner = [&](std::size_t i) { return body.mesh.nodes[facet.corners[i]]; };
    const std::array<Vec3, 3> corners{corner(0), corner(1), corner(2)};
    const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    splitter.add({number.at(facet.corners), corners, normal});
  }
  return splitter.take();
}

namespace {

// Colours at the nodes of the surface. weight: by node of the mesh; a clamped node has none.
void colour_nodes(const std::map<NodeIndex, double>& weight, const ShownBody& shown, ShownPad& pad) {
  for (std::size_t t = 0; t < shown.triangles.size(); ++t) {
    const auto known = [&](NodeIndex own) { return weight.contains(shown.node[own]); };
    if (std::ranges::none_of(shown.triangles[t], known)) continue;
    Triangle part{};
    for (std::size_t i = 0; i < 3; ++i) {
      const NodeIndex own = shown.triangles[t][i];
      part[i] = static_cast<NodeIndex>(pad.facet.size());
      pad.facet.push_back(static_cast<std::uint32_t>(t));
      pad.at.push_back(Vec3::Unit(static_cast<int>(i)));
      pad.weight.push_back(known(own) ? weight.at(shown.node[own]) : 1);
    }
    pad.triangles.push_back(part);
  }
}

}  // namespace

std::string_view name(PadShade shade) {
  return shade == PadShade::springs ? "springs" : shade == PadShade::stiffness ? "stiffness" : "error";
}

std::optional<ShownPad> shown_stiffness(const std::vector<SurfaceStiffness>& map, const ShownBody& shown) {
  const std::optional<StiffnessRange> range = range_over(map, &SurfaceStiffness::alone);
  if (!range) return {};
  ShownPad pad;
  pad.shade = PadShade::stiffness;
  pad.least = range->least, pad.peak = range->greatest;
  std::map<NodeIndex, double> weight;
  const double span = std::max(range->greatest - range->least, 1e-12 * range->greatest);
  for (const SurfaceStiffness& at : map) weight[at.node] = (at.alone - range->least) / span;
  colour_nodes(weight, shown, pad);
  return pad;
}

std::optional<ShownPad> shown_error(const std::vector<SurfaceError>& map, double tolerance, double depth,
                                    const ShownBody& shown) {
  if (map.empty()) return {};
  ShownPad pad;
  pad.shade = PadShade::error;
  pad.peak = tolerance, pad.depth = depth;
  std::map<NodeIndex, double> weight;
  double area = 0, above = 0;
  for (const SurfaceError& at : map) {
    weight[at.node] = std::min(1.0, at.error / tolerance);
    area += at.area, above += at.error > tolerance ? at.area : 0;
  }
  pad.share = above / area;
  colour_nodes(weight, shown, pad);
  return pad;
}

namespace {

// Position of each node of the mesh in the surface; no_node inside.
std::vector<NodeIndex> places(const ShownBody& body, std::size_t mesh_nodes) {
  std::vector<NodeIndex> place(mesh_nodes, no_node);
  for (std::size_t i = 0; i < body.node.size(); ++i) place[body.node[i]] = static_cast<NodeIndex>(i);
  return place;
}

void take_groups(ShownBody& body) {
  const std::vector<NodeIndex> place = places(body, body.mesh.nodes.size());
  for (const auto& [name, nodes] : body.mesh.groups) {
    ShownGroup group{.name = name, .nodes = {}};
    for (const NodeIndex node : nodes)
      if (const NodeIndex at = place[node]; at != no_node) group.nodes.push_back(at);
    std::ranges::sort(group.nodes);
    if (!group.nodes.empty()) body.groups.push_back(std::move(group));
  }
}

}  // namespace

namespace {

ShownBody surface_of(const TetMesh& mesh) {
  ShownBody body;
  body.mesh = mesh;
  body.node = surface_nodes(mesh);
  for (const NodeIndex node : body.node) body.nodes.push_back(mesh.nodes[node]);
  const std::vector<NodeIndex> place = places(body, mesh.nodes.size());
  for (const Triangle& t : boundary_triangles(mesh)) {
    Triangle own{};
    for (std::size_t i = 0; i < 3; ++i) own[i] = place[t[i]];
    body.triangles.push_back(own);
  }
  body.role.assign(body.nodes.size(), Role::free);
  take_groups(body);
  return body;
}

}  // namespace

ShownBody shown_body(const TetMesh& mesh) {
  ShownBody body = surface_of(mesh);
  take_regions(mesh, body);
  return body;
}

namespace {

// With its clamp and contact.
ShownBody with_roles(const Body& body) {
  ShownBody shown = surface_of(body.mesh);
  take_regions(body, shown);
  const std::vector<NodeIndex> place = places(shown, body.mesh.nodes.size());
  const auto mark = [&](const std::vector<NodeIndex>& nodes, Role role) {
    for (const NodeIndex node : nodes)
      if (const NodeIndex at = place[node]; at != no_node) shown.role[at] = role;
  };
  mark(body.clamp, Role::clamp);
  mark(body.contact, Role::contact);
  return shown;
}

}  // namespace

ShownBody shown_anywhere(const Scene& scene, const Globals& globals, std::optional<double> trust,
                         std::span<const State> states) {
  ShownBody shown = with_roles(*scene.body);
  const std::shared_ptr<const SiteField> field = site_field_of(scene, globals);
  if (!trust) {
    shown.pad = shown_stiffness(palpation_map(field->rest(), *scene.body, globals.threads), shown);
    return shown;
  }
  const auto known = field_with(field, states, std::max(1, globals.threads));
  shown.pad =
      shown_error(error_map(*known, *scene.body, *trust, scene.session.judging.error_floor, globals.threads),
                  scene.spacing.tolerance, *trust, shown);
  return shown;
}

ShownBody shown_body(const Body& body) {
  ShownBody shown = with_roles(body);
  shown.pad = shown_pad(body, shown);
  shown.rest = rest_of_contact(body);
  for (Vec3& node : shown.nodes) node -= shown.rest;
  for (Vec3& node : shown.regions.inside.nodes) node -= shown.rest;
  shown.outward = -inward_direction(body);
  return shown;
}

ShownBody shown_body(const Surface& surface) {
  ShownBody body;
  body.nodes = surface.nodes;
  body.triangles = surface.triangles;
  for (std::size_t i = 0; i < surface.nodes.size(); ++i) body.node.push_back(static_cast<NodeIndex>(i));
  body.role.assign(surface.nodes.size(), Role::free);
  return body;
}

}  // namespace forefeel
