#include "solver/equilibrium/fine_body.hpp"

#include <fmt/format.h>

#include "geometry/common/sha256.hpp"
#include "solver/body/body_digest.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {

RestJet rest_jet(const Body& body, const InputPlace& where) {
  Solver solver(body);
  SolveOptions options;
  options.jet = most_jet_order;
  const State state = solver.reference(Vec3::Zero(), 1, options).state;
  if (!state.usable() || !state.jet) throw InputError(where, "the body has no stable equilibrium at rest");
  return {state.stiffness, *state.jet};
}

std::string fine_body_in_words(const Body& fine) {
  Sha256 hash;
  for (const auto& [key, value] : identity_of(fine))
    hash.add(std::string_view(key)).add(std::string_view(value));
  return fmt::format("{} elements, {} tetrahedra, sha256 {}", name(fine.element), fine.mesh.tets.size(),
                     hash.hex());
}

}  // namespace forefeel
