#include "solver/jet/rest_jet.hpp"

#include <fmt/format.h>

#include <vector>

#include "geometry/common/sha256.hpp"
#include "solver/body/body_digest.hpp"
#include "solver/jet/jet_maker.hpp"

namespace forefeel {

RestJet rest_jet(const Body& body, const InputPlace& where) {
  const std::shared_ptr<const Discretisation> d = analyse(body);
  const auto size = static_cast<std::size_t>(d->local_size());
  const std::vector<double> rest(size, 0.0);
  Factorisation factor(*d);
  {
    std::vector<double> blocks(9 * static_cast<std::size_t>(d->pattern.size() + 1), 0.0);
    d->elements.hessian(rest.data(), blocks.data());
    if (!factor.compute(blocks.data())) throw InputError(where, "the body has no stable equilibrium at rest");
  }
  std::vector<double> tangent(3 * size);
  factor.tangent(tangent.data());
  return {factor.stiffness(), JetMaker(d).at(rest, tangent, factor, most_jet_order)};
}

std::string fine_body_in_words(const Body& fine) {
  Sha256 hash;
  for (const auto& [key, value] : identity_of(fine))
    hash.add(std::string_view(key)).add(std::string_view(value));
  return fmt::format("{} elements, {} tetrahedra, sha256 {}", name(fine.element), fine.mesh.tets.size(),
                     hash.hex());
}

}  // namespace forefeel
