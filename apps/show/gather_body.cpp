#include "apps/show/gather_body.hpp"

#include <algorithm>
#include <utility>

#include "apps/console/console.hpp"
#include "apps/scene/field_check.hpp"
#include "apps/scene/palpation_map.hpp"
#include "apps/scene/scene_body.hpp"
#include "apps/scene/scene_field.hpp"
#include "apps/show/gather_pad.hpp"
#include "apps/show/gather_regions.hpp"

namespace forefeel {
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
