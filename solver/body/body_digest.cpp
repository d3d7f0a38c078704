#include "solver/body/body_digest.hpp"

#include <fmt/format.h>

#include <set>

#include "geometry/common/sha256.hpp"
#include "solver/body/fine_jet.hpp"

namespace forefeel {
namespace {

std::string hash_nodes(const std::vector<NodeIndex>& nodes) {
  Sha256 hash;
  for (const NodeIndex node : nodes) hash.add(std::int64_t{node});
  return "sha256 " + hash.hex();
}

std::string in_words(const Material& material) {
  return fmt::format("{}, young {} Pa, poisson {}", name(material.law), material.young, material.poisson);
}

// One material in words; of several, also the tetrahedra of each but the first.
std::string material_of(const Body& body) {
  if (body.regions.empty()) return in_words(body.material);
  std::string text;
  for (const MaterialPart& part : material_parts(body)) {
    if (!text.empty()) {
      Sha256 hash;
      for (const TetIndex tet : part.tets) hash.add(std::int64_t{tet});
      text += fmt::format("; {} tetrahedra (sha256 {}): ", part.tets.size(), hash.hex());
    }
    text += in_words(part.material);
  }
  return text;
}

// The forms of the laws in use that have several. States of another form have other forces.
std::string forms_of(const Body& body) {
  std::set<Law> laws;
  for (const MaterialPart& part : material_parts(body)) laws.insert(part.material.law);
  std::string text;
  for (const Law law : laws)
    if (!form(law).empty()) text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", name(law), form(law));
  return text;
}

std::string contact_of(const Body& body) {
  if (!body.pad) return hash_nodes(body.contact);
  const auto& [site, radius, stiffness] = *body.pad;
  return fmt::format("pad of {} N/m, radius {} m, at ({}, {}, {})", stiffness, radius, site.x(), site.y(),
                     site.z());
}

}  // namespace

BodyIdentity identity_of(const Body& body) {
  Sha256 mesh;
  mesh.add(static_cast<std::int64_t>(body.mesh.nodes.size()));
  for (const Vec3& node : body.mesh.nodes)
    for (const double coordinate : node) mesh.add(coordinate);
  for (const Tet& tet : body.mesh.tets)
    for (const NodeIndex node : tet) mesh.add(std::int64_t{node});
  BodyIdentity identity{{"mesh", "sha256 " + mesh.hex()},
                        {"element", std::string(name(body.element))},
                        {"material", material_of(body)},
                        {"clamp", hash_nodes(body.clamp)},
                        {"contact", contact_of(body)}};
  if (const std::string forms = forms_of(body); !forms.empty()) identity["form of the law"] = forms;
  if (body.fine) identity["fine"] = body.fine->fine_body();
  return identity;
}

}  // namespace forefeel
