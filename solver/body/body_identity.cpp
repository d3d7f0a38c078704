#include "solver/body/body_identity.hpp"

#include <fmt/format.h>

#include "geometry/common/sha256.hpp"

namespace forefeel {
namespace {

std::string hash_nodes(const std::vector<NodeIndex>& nodes) {
  Sha256 hash;
  for (const NodeIndex node : nodes) hash.add(std::int64_t{node});
  return "sha256 " + hash.hex();
}

}  // namespace

BodyIdentity identity_of(const Body& body) {
  Sha256 mesh;
  mesh.add(static_cast<std::int64_t>(body.mesh.nodes.size()));
  for (const Vec3& node : body.mesh.nodes)
    for (const double coordinate : node) mesh.add(coordinate);
  for (const Tet& tet : body.mesh.tets)
    for (const NodeIndex node : tet) mesh.add(std::int64_t{node});
  return {{"mesh", "sha256 " + mesh.hex()},
          {"element", std::string(name(body.element))},
          {"material", fmt::format("{}, young {} Pa, poisson {}", name(body.material.law),
                                   body.material.young, body.material.poisson)},
          {"clamp", hash_nodes(body.clamp)},
          {"contact", hash_nodes(body.contact)}};
}

}  // namespace forefeel
