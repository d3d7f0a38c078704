#pragma once
// Blocks with regions of other materials.

#include <string>
#include <vector>

#include "block_body.hpp"

namespace forefeel {

// The tetrahedra whose centre is in the box.
inline std::vector<TetIndex> tets_within(const TetMesh& mesh, const Box& box) {
  std::vector<TetIndex> tets;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    Vec3 centre = Vec3::Zero();
    for (const NodeIndex node : mesh.tets[t]) centre += mesh.nodes[static_cast<std::size_t>(node)] / 4;
    if (box.contains(centre)) tets.push_back(static_cast<TetIndex>(t));
  }
  return tets;
}

// The block of block_body() with an inclusion in its middle that reaches one long edge, and perhaps an end of a
// third material that holds the contact.
inline std::shared_ptr<Body> region_body(const Material& rest, const Material& inclusion,
                                         const Material* end = nullptr, int refine = 1,
                                         Element element = Element::linear) {
  const auto body = block_body(rest.law, rest.poisson, refine, element);
  body->material = rest;
  body->regions.push_back(
      {"inclusion", inclusion, tets_within(body->mesh, {Vec3(0.02, 0, 0), Vec3(0.06, 0.02, 0.02)})});
  if (end)
    body->regions.push_back(
        {"end", *end, tets_within(body->mesh, {Vec3(0.08, 0, 0), Vec3(0.1, 0.04, 0.04)})});
  return body;
}

}  // namespace forefeel
