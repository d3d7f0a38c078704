#include "solver/equilibrium/state_jets.hpp"

#include <utility>

namespace forefeel {

StateJets::StateJets(std::shared_ptr<const Discretisation> discretisation) : d_(std::move(discretisation)) {}

std::shared_ptr<const EnergyJet> StateJets::at(const LocalField& field, const Factorisation& factor,
                                               int order) {
  if (!maker_) maker_.emplace(d_);
  return std::make_shared<const EnergyJet>(maker_->at(field.u, field.tangent, factor, order));
}

std::shared_ptr<const EnergyJet> StateJets::near(std::vector<double> u, int order) {
  if (!newton_) newton_.emplace(d_);
  constexpr int most_iterations = 20;
  field_.u = std::move(u);
  if (newton_->solve(field_.u, jet_tolerance, most_iterations, {}).status != SolveStatus::converged)
    return {};
  field_.tangent.resize(3 * field_.u.size());
  newton_->factor().tangent(field_.tangent.data());
  return at(field_, newton_->factor(), order);
}

}  // namespace forefeel
