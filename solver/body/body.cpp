#include "solver/body/body.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "geometry/common/error.hpp"
#include "solver/body/material_limits.hpp"

namespace forefeel {
namespace {

void check_nodes(const std::vector<NodeIndex>& nodes, const TetMesh& mesh, const InputPlace& where) {
  if (nodes.empty()) throw InputError(where, "no node is in it, expected at least one");
  for (const NodeIndex node : nodes) {
    if (node < 0 || static_cast<std::size_t>(node) >= mesh.nodes.size())
      throw InputError(where,
                       fmt::format("node {} is out of range, expected 0 to {}", node, mesh.nodes.size() - 1));
  }
}

void check_material(const Material& material, const std::string& file) {
  if (!(material.young >= softest_young && material.young <= stiffest_young))
    throw InputError({.file = file, .key = "material.young"},
                     fmt::format("{} Pa, expected more than 0, from {:g} to {:g}", material.young,
                                 softest_young, stiffest_young));
  if (!(material.poisson > -1 && material.poisson < 0.5))
    throw InputError({.file = file, .key = "material.poisson"},
                     fmt::format("{}, expected more than -1 and less than 0.5", material.poisson));
}

void check_parts(const Body& body, const std::string& file) {
  const std::vector<int> part = components(body.mesh);
  int parts = 0;
  for (const int p : part) parts = std::max(parts, p + 1);
  std::vector<char> clamped(static_cast<std::size_t>(parts), 0);
  for (const NodeIndex node : body.clamp)
    if (part[static_cast<std::size_t>(node)] >= 0)
      clamped[static_cast<std::size_t>(part[static_cast<std::size_t>(node)])] = 1;
  const auto loose = std::count(clamped.begin(), clamped.end(), 0);
  if (loose > 0)
    throw InputError({.file = file, .key = "clamp"},
                     fmt::format("{} of the {} connected parts of the mesh {} no clamped node, "
                                 "expected one in each",
                                 loose, parts, loose == 1 ? "has" : "have"));
  for (const NodeIndex node : body.contact)
    if (part[static_cast<std::size_t>(node)] < 0)
      throw InputError({.file = file, .key = "contact"},
                       fmt::format("node {} belongs to no tetrahedron", node));
}

}  // namespace

std::string_view name(Element element) {
  return element == Element::linear ? "linear" : "quadratic";
}

std::vector<std::string> element_names() {
  return {"linear", "quadratic"};
}

namespace {
// If all held nodes lie on one line, the body can turn about it and its equilibrium is not unique.
void check_held(const Body& body, const std::string& file) {
  std::vector<Vec3> held;
  for (const auto* nodes : {&body.clamp, &body.contact})
    for (const NodeIndex node : *nodes) held.push_back(body.mesh.nodes[static_cast<std::size_t>(node)]);
  const auto further = [&](const Vec3& a, const Vec3& b) {
    return (a - held[0]).norm() < (b - held[0]).norm();
  };
  const Vec3 far = *std::max_element(held.begin(), held.end(), further) - held[0];
  const double length = longest_side(body.mesh);
  for (const Vec3& node : held)
    if ((node - held[0]).cross(far).norm() > 1e-9 * length * length) return;
  throw InputError({.file = file, .key = "clamp"},
                   "clamp and contact lie on one line, so the body can turn about it, "
                   "expected at least three nodes off a line");
}
}  // namespace

std::vector<std::string> check(const Body& body, const std::string& file) {
  if (body.mesh.tets.empty())
    throw InputError({.file = file, .key = "body.mesh"}, "no tetrahedra, expected at least one");
  check_material(body.material, file);
  check_nodes(body.clamp, body.mesh, {.file = file, .key = "clamp"});
  check_nodes(body.contact, body.mesh, {.file = file, .key = "contact"});
  std::vector<char> clamped(body.mesh.nodes.size(), 0);
  for (const NodeIndex node : body.clamp) clamped[static_cast<std::size_t>(node)] = 1;
  for (const NodeIndex node : body.contact)
    if (clamped[static_cast<std::size_t>(node)])
      throw InputError({.file = file, .key = "contact"},
                       fmt::format("node {} is clamped, expected a node that can move", node));
  check_parts(body, file);
  check_held(body, file);

  std::vector<std::string> warnings;
  if (body.material.poisson > 0.45 && body.element == Element::linear)
    warnings.push_back(
        fmt::format("material.poisson = {}: linear tetrahedra lock above 0.45 and answer too stiffly; "
                    "body.element = \"quadratic\" does not",
                    body.material.poisson));
  if (body.contact.size() == 1)
    warnings.push_back(
        "the contact is one node: its force falls without limit as the mesh is refined; give a radius that "
        "takes several");
  return warnings;
}

bool is_linear(const Body& body) {
  return law_entry(body.material.law).linear;
}

}  // namespace forefeel
