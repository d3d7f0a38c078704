#include "solver/lattice/node_states.hpp"
#include "geometry/states/energy_jet.hpp"

#include <chrono>
#include <utility>
#include <vector>

namespace forefeel {

NodeStates::NodeStates(std::shared_ptr<const Discretisation> discretisation, const Body& body,
                       const GenerateOptions& options)
    : d_(std::move(discretisation)),
      nodes_(body.mesh.nodes.size()),
      linear_(is_linear(body)),
      displacements_(options.want_displacements),
      jet_(options.jet),
      jets_(d_) {}

State NodeStates::of(const SweepNode& node) {
  State state = node.state;
  if (!state.usable()) return state;
  if (displacements_) {
    std::vector<double> u = d_->to_nodes(node.field.u.data());
    u.resize(3 * nodes_);
    state.displacements = std::make_shared<const std::vector<double>>(std::move(u));
  }
  if (jet_ > 1) {
    const auto start = std::chrono::steady_clock::now();
    state.jet = linear_ ? std::make_shared<const EnergyJet>(EnergyJet{.order = jet_})
                        : jets_.near(node.field.u, jet_);
    state.solve.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  return state;
}

}  // namespace forefeel
