#pragma once
// Energy jets of solved states (solver/jet/jet_maker.hpp). A jet needs the equilibrium to about 1e-9 N and the exact
// factor there, so a state that was solved less exactly, or with a neighbour's factor, is first corrected by Newton's
// method; its force and stiffness stay as they were found.

#include <memory>
#include <optional>
#include <vector>

#include "solver/equilibrium/lane_solver.hpp"
#include "solver/equilibrium/newton.hpp"
#include "solver/jet/jet_maker.hpp"

namespace forefeel {

// Residual, relative to the force, of an equilibrium that is exact enough for its jet.
inline constexpr double jet_tolerance = 1e-10;

// Work space of one body for one thread; it makes its factor at the first call that needs one.
class StateJets {
 public:
  explicit StateJets(std::shared_ptr<const Discretisation> discretisation);

  // Corrects u first. Null if no stable equilibrium is found there.
  std::shared_ptr<const EnergyJet> near(std::vector<double> u, int order);
  // With the exact factor of H(u).
  std::shared_ptr<const EnergyJet> at(const LocalField& field, const Factorisation& factor, int order);

 private:
  std::shared_ptr<const Discretisation> d_;
  std::optional<JetMaker> maker_;
  std::optional<NewtonSolver> newton_;
  LocalField field_;
};

}  // namespace forefeel
