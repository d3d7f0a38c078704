#pragma once
// The states of solved nodes (sweep.hpp), with what else is wanted of them: displacements, energy jets.

#include <cstddef>
#include <memory>

#include "solver/equilibrium/state_jets.hpp"
#include "solver/lattice/generate.hpp"
#include "solver/lattice/sweep.hpp"

namespace forefeel {

// For one thread. A node's field is exact enough for its force, not for a jet, and its factor may be a neighbour's: for
// the jet it is corrected first. A jet depends on the node alone. Null where the corrected field is no stable
// equilibrium.
class NodeStates {
 public:
  NodeStates(std::shared_ptr<const Discretisation> discretisation, const Body& body,
             const GenerateOptions& options);
  // seconds: those of the jet are added.
  State of(const SweepNode& node);

 private:
  std::shared_ptr<const Discretisation> d_;
  std::size_t nodes_;  // of the mesh; mid-edge nodes are not reported
  bool linear_, displacements_;
  int jet_;
  StateJets jets_;
};

}  // namespace forefeel
