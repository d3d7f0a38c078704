// check() and clamped_share() of body.hpp.
#include "solver/body/body.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <set>

#include "geometry/common/error.hpp"
#include "solver/body/material.hpp"
#include "solver/body/pad.hpp"

namespace forefeel {
namespace {

void check_nodes(const std::vector<NodeIndex>& nodes, const TetMesh& mesh, const InputPlace& where) {
  if (nodes.empty()) throw InputError(where, "no node is in it, expected at least one");
  for (const NodeIndex node : nodes) {
    if (node >= mesh.nodes.size())
      throw InputError(where,
                       fmt::format("node {} is out of range, expected 0 to {}", node, mesh.nodes.size() - 1));
  }
}

void check_material(const Material& material, const std::string& file, const std::string& key) {
  if (!(material.young >= softest_young && material.young <= stiffest_young))
    throw InputError({.file = file, .key = key + ".young"},
                     fmt::format("{} Pa, expected more than 0, from {:g} to {:g}", material.young,
                                 softest_young, stiffest_young));
  if (!(material.poisson > -1 && material.poisson < 0.5))
    throw InputError({.file = file, .key = key + ".poisson"},
                     fmt::format("{}, expected more than -1 and less than 0.5", material.poisson));
}

std::string key_of(const MaterialRegion& region) {
  return "material." + region.name;
}

void check_regions(const Body& body, const std::string& file) {
  std::vector<const MaterialRegion*> owner(body.mesh.tets.size(), nullptr);
  for (const MaterialRegion& region : body.regions) {
    const InputPlace where{.file = file, .key = key_of(region)};
    if (region.tets.empty()) throw InputError(where, "no tetrahedron is in it, expected at least one");
    for (const TetIndex tet : region.tets) {
      if (tet >= owner.size())
        throw InputError(
            where, fmt::format("tetrahedron {} is out of range, expected 0 to {}", tet, owner.size() - 1));
      const MaterialRegion*& its = owner[tet];
      if (its)
        throw InputError(where, fmt::format("tetrahedron {} is in '{}' too, expected one material for each",
                                            tet, its->name));
      its = &region;
    }
    check_material(region.material, file, key_of(region));
  }
  if (has_rest(body)) check_material(body.material, file, "material");
}

void check_parts(const Body& body, const std::string& file) {
  const std::vector<int> part = components(body.mesh);
  const int parts = std::ranges::max(part) + 1;
  std::set<int> clamped;
  for (const NodeIndex node : body.clamp)
    if (part[node] >= 0) clamped.insert(part[node]);
  const int loose = parts - static_cast<int>(clamped.size());
  if (loose > 0)
    throw InputError({.file = file, .key = "clamp"},
                     fmt::format("{} of the {} connected parts of the mesh {} no clamped node, "
                                 "expected one in each",
                                 loose, parts, loose == 1 ? "has" : "have"));
  for (const NodeIndex node : body.contact)
    if (part[node] < 0)
      throw InputError({.file = file, .key = "contact"},
                       fmt::format("node {} belongs to no tetrahedron", node));
}

bool on_one_line(const std::vector<Vec3>& points, double length) {
  if (points.empty()) return true;
  const auto further = [&](const Vec3& a, const Vec3& b) {
    return (a - points[0]).norm() < (b - points[0]).norm();
  };
  const Vec3 far = *std::max_element(points.begin(), points.end(), further) - points[0];
  return std::ranges::all_of(points, [&](const Vec3& point) {
    return (point - points[0]).cross(far).norm() <= 1e-9 * length * length;
  });
}

// Rejects a part that can turn about a node or an edge, by which it hangs on the rest: its stiffness is singular.
void check_hinges(const Body& body, const std::string& file) {
  const TetMesh& mesh = body.mesh;
  const std::vector<int> part = face_parts(mesh);
  const int parts = std::ranges::max(part) + 1;
  if (parts == 1) return;
  std::vector<char> held(mesh.nodes.size(), 0);
  for (const auto* nodes : {&body.clamp, &body.contact})
    for (const NodeIndex node : *nodes) held[node] = 1;
  if (body.pad)
    for (const PadFacet& facet : pad_surface(mesh, *body.pad).facets)
      for (const NodeIndex node : facet.corners) held[node] = 1;
  std::vector<std::set<NodeIndex>> nodes_of(static_cast<std::size_t>(parts));
  std::vector<int> first(mesh.nodes.size(), -1);
  std::vector<char> shared(mesh.nodes.size(), 0);
  for (std::size_t t = 0; t < part.size(); ++t)
    for (const NodeIndex node : mesh.tets[t]) {
      nodes_of[static_cast<std::size_t>(part[t])].insert(node);
      if (first[node] < 0) first[node] = part[t];
      if (first[node] != part[t]) shared[node] = 1;
    }
  const double length = longest_side(mesh);
  for (std::size_t p = 0; p < nodes_of.size(); ++p) {
    std::vector<Vec3> at;
    for (const NodeIndex node : nodes_of[p])
      if (held[node] || shared[node]) at.push_back(mesh.nodes[node]);
    if (!on_one_line(at, length)) continue;
    throw InputError(
        {.file = file, .key = "body.mesh"},
        fmt::format("part {} of the mesh ({} tetrahedra) hangs on {}: it can turn freely, expected "
                    "parts joined by faces, or clamped nodes in each",
                    p + 1, std::ranges::count(part, static_cast<int>(p)),
                    at.size() == 1 ? "1 node" : fmt::format("{} nodes of one line", at.size())));
  }
}

}  // namespace

namespace {
// Rejects held nodes that all lie on one line: the body could rotate about it, and its equilibrium is not unique.
void check_held(const Body& body, const std::string& file) {
  if (body.pad) return;  // its springs hold more than a line
  const std::vector<char> used = used_nodes(body.mesh);
  std::vector<Vec3> held;
  for (const auto* nodes : {&body.clamp, &body.contact})
    for (const NodeIndex node : *nodes)
      if (used[node]) held.push_back(body.mesh.nodes[node]);
  if (!on_one_line(held, longest_side(body.mesh))) return;
  throw InputError({.file = file, .key = "clamp"},
                   "clamp and contact lie on one line, so the body can turn about it, "
                   "expected at least three nodes off a line");
}
}  // namespace

namespace {

void check_pad(const Body& body, const InputPlace& where) {
  const Pad& pad = *body.pad;
  if (!body.contact.empty()) throw InputError(where, "both nodes and a pad are given, expected one of them");
  if (!(pad.radius > 0 && std::isfinite(pad.radius) && pad.stiffness > 0 && std::isfinite(pad.stiffness)))
    throw InputError(where, fmt::format("a pad of radius {} m and {} N/m, expected both above 0", pad.radius,
                                        pad.stiffness));
  const PadSurface surface = pad_surface(body.mesh, pad);
  if (!(surface.stiffness > 0))
    throw InputError(where,
                     fmt::format("no surface under the pad at ({:.6g}, {:.6g}, {:.6g}), expected a site on "
                                 "the surface of the mesh",
                                 pad.site.x(), pad.site.y(), pad.site.z()));
  if (clamped_share(body, surface) == 1)
    throw InputError(where, "all nodes under the pad are clamped, expected a place that can move");
}

void warn_of_pad(const Pad& pad, const PadSurface& surface, std::vector<std::string>& warnings) {
  if (surface.stiffness < 0.3 * pad.stiffness)
    warnings.push_back(
        fmt::format("the pad's springs amount to {:.3g} N/m, less than 0.3 of its {:g} N/m: the site is "
                    "at a sharp rim or the body is smaller than the pad",
                    surface.stiffness, pad.stiffness));
  if (surface.normal.isZero())
    warnings.push_back("the mean normal under the pad vanishes: the body is thinner than the pad is wide");
  if (surface.other_part)
    warnings.push_back(
        "the pad's ball holds another part of the surface, which its springs leave out: the force is "
        "not continuous in the site there");
}

}  // namespace

double clamped_share(const Body& body, const PadSurface& surface) {
  double all = 0, held = 0;
  for (const PadFacet& facet : surface.facets)
    for (std::size_t i = 0; i < 3; ++i) {
      const double own = facet.springs[i][0] + facet.springs[i][1] + facet.springs[i][2];
      all += own;
      if (std::ranges::binary_search(body.clamp, facet.corners[i])) held += own;
    }
  return held < all ? held / all : 1;
}

std::vector<std::string> check(const Body& body, const std::string& file) {
  if (body.mesh.tets.empty())
    throw InputError({.file = file, .key = "body.mesh"}, "no tetrahedra, expected at least one");
  check_regions(body, file);
  check_nodes(body.clamp, body.mesh, {.file = file, .key = "clamp"});
  if (body.pad)
    check_pad(body, {.file = file, .key = "contact"});
  else
    check_nodes(body.contact, body.mesh, {.file = file, .key = "contact"});
  std::vector<char> clamped(body.mesh.nodes.size(), 0);
  for (const NodeIndex node : body.clamp) clamped[node] = 1;
  for (const NodeIndex node : body.contact)
    if (clamped[node])
      throw InputError({.file = file, .key = "contact"},
                       fmt::format("node {} is clamped, expected a node that can move", node));
  check_parts(body, file);
  check_held(body, file);
  check_hinges(body, file);

  std::vector<std::string> warnings;
  const auto locking = [&](const Material& material, const std::string& key) {
    if (material.poisson > 0.45 && body.element == Element::linear)
      warnings.push_back(
          fmt::format("{}.poisson = {}: linear tetrahedra lock above 0.45 and answer too stiffly; "
                      "body.element = \"quadratic\" does not",
                      key, material.poisson));
  };
  if (has_rest(body)) locking(body.material, "material");
  for (const MaterialRegion& region : body.regions) locking(region.material, key_of(region));
  if (body.pad) warn_of_pad(*body.pad, pad_surface(body.mesh, *body.pad), warnings);
  if (body.contact.size() == 1)
    warnings.push_back(
        "the contact is one node: its force falls without limit as the mesh is refined; give a radius that "
        "takes several");
  return warnings;
}

}  // namespace forefeel
