#include "solver/body/refined_body.hpp"

#include <string>
#include <utility>

#include "geometry/mesh/subdivided_mesh.hpp"

namespace forefeel {

Body refined(const Body& body) {
  Body fine = body;
  fine.fine.reset();
  // Sets and regions are split as groups are.
  fine.mesh.groups = {{"clamp", body.clamp}, {"contact", body.contact}};
  fine.mesh.element_groups.clear();
  for (std::size_t k = 0; k < body.regions.size(); ++k)
    fine.mesh.element_groups[std::to_string(k)] = body.regions[k].tets;
  fine.mesh = subdivided(fine.mesh);
  fine.clamp = std::move(fine.mesh.groups.at("clamp"));
  fine.contact = std::move(fine.mesh.groups.at("contact"));
  for (std::size_t k = 0; k < fine.regions.size(); ++k)
    fine.regions[k].tets = std::move(fine.mesh.element_groups.at(std::to_string(k)));
  fine.mesh.groups.clear();
  fine.mesh.element_groups.clear();
  return fine;
}

std::int64_t estimated_nodes(const Body& body) {
  const auto corners = static_cast<std::int64_t>(body.mesh.nodes.size());
  const auto tets = static_cast<std::int64_t>(body.mesh.tets.size());
  return body.element == Element::linear ? corners : 2 * corners + tets;
}

std::int64_t estimated_nodes_refined(const Body& body) {
  const auto corners = static_cast<std::int64_t>(body.mesh.nodes.size());
  const auto tets = static_cast<std::int64_t>(body.mesh.tets.size());
  const std::int64_t fine_corners = 2 * corners + tets;  // corners and edges
  // Each edge in two, three in each face, one in each octahedron.
  const std::int64_t fine_edges = 2 * (corners + tets) + 3 * 2 * tets + tets;
  return body.element == Element::linear ? fine_corners : fine_corners + fine_edges;
}

}  // namespace forefeel
