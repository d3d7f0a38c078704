#include "solver/body/body.hpp"

#include <algorithm>

#include "solver/body/law.hpp"

namespace forefeel {

std::string_view name(Element element) {
  return element == Element::linear ? "linear" : "quadratic";
}

bool has_rest(const Body& body) {
  std::size_t in_regions = 0;
  for (const MaterialRegion& region : body.regions) in_regions += region.tets.size();
  return in_regions < body.mesh.tets.size() || body.regions.empty();
}

Vec3 rest_of_contact(const Body& body) {
  if (body.pad) return body.pad->site;
  Vec3 sum = Vec3::Zero();
  for (const NodeIndex node : body.contact) sum += body.mesh.nodes[node];
  return sum / static_cast<double>(std::max<std::size_t>(1, body.contact.size()));
}

std::vector<MaterialPart> material_parts(const Body& body) {
  std::vector<const Material*> of(body.mesh.tets.size(), &body.material);
  for (const MaterialRegion& region : body.regions)
    for (const TetIndex tet : region.tets) of[tet] = &region.material;
  std::vector<MaterialPart> parts;
  for (std::size_t tet = 0; tet < of.size(); ++tet) {
    auto part = std::ranges::find(parts, *of[tet], &MaterialPart::material);
    if (part == parts.end()) part = parts.insert(part, {*of[tet], {}});
    part->tets.push_back(static_cast<TetIndex>(tet));
  }
  return parts;
}

std::vector<Material> materials(const Body& body) {
  std::vector<Material> distinct;
  const auto add = [&](const Material& material) {
    if (std::ranges::find(distinct, material) == distinct.end()) distinct.push_back(material);
  };
  if (has_rest(body)) add(body.material);
  for (const MaterialRegion& region : body.regions) add(region.material);
  return distinct;
}

bool is_linear(const Body& body) {
  if (body.regions.empty()) return law_entry(body.material.law).linear;
  return std::ranges::all_of(materials(body),
                             [](const Material& material) { return law_entry(material.law).linear; });
}

}  // namespace forefeel
