#pragma once
// How a solve ended, as it is counted, printed and written. In memory `converged` says that the equations
// hold. They can also hold where an element is turned inside out (least det F <= 0), a shape that no body
// takes. Such a state stays usable, for its force is that of the mesh, but its outcome is `inverted`, and no
// count of converged states includes it.

#include <cstddef>
#include <string>

#include "geometry/states/state.hpp"

namespace forefeel {

// False where det F is not known: measured states and those of other programs.
inline bool has_inverted_elements(const State& state) {
  return state.status == SolveStatus::converged && state.min_jacobian <= 0;
}
inline SolveStatus outcome(const State& state) {
  return has_inverted_elements(state) ? SolveStatus::inverted : state.status;
}

// ", 28 of them with inverted elements", or nothing.
inline std::string inverted_in_words(std::size_t inverted) {
  return inverted > 0 ? ", " + std::to_string(inverted) + " of them with inverted elements" : std::string();
}

}  // namespace forefeel
