#pragma once
// All states of the lattice {k h}^3 inside a box, each on the reference branch: the primary equilibrium path, followed
// from rest straight to the state.

#include <functional>
#include <memory>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/body/body.hpp"
#include "solver/lattice/generate_options.hpp"

namespace forefeel {

// Solves every lattice point of the box that `known` does not hold, outward from rest. Failed states in
// `known` are not retried. sink(state) receives each new state, failed ones included; progress(done, total)
// reports. Both are called from one thread at a time.
// A state is marked multivalued if its straight path jumps within its last two steps, if another path ends at
// another equilibrium, or if its force differs from what the stiffnesses of its neighbours predict.
GenerateReport generate_lattice(std::shared_ptr<const Body> body, const GenerateOptions& options,
                                const std::vector<State>& known, const std::function<void(State)>& sink,
                                const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace forefeel
