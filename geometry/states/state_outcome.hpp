#pragma once
// The outcome of a solve, as it is counted, printed and written. In memory, `converged` means that the equations are
// satisfied. This is possible even with an element turned inside out (least det F <= 0), which no real body does. Such
// a state is usable, because its force is that of the mesh, but its outcome is `inverted`, not converged.

#include <cstddef>
#include <string>

#include "geometry/states/state.hpp"

namespace forefeel {

// False if det F is unknown, as for measured states and states of other programs.
inline bool has_inverted_elements(const State& state) {
  return state.solve.status == SolveStatus::converged && state.solve.min_jacobian <= 0;
}
inline SolveStatus outcome(const State& state) {
  return has_inverted_elements(state) ? SolveStatus::inverted : state.solve.status;
}

// ", 28 of them with inverted elements", or nothing.
inline std::string inverted_in_words(std::size_t inverted) {
  return inverted > 0 ? ", " + std::to_string(inverted) + " of them with inverted elements" : std::string();
}

}  // namespace forefeel
