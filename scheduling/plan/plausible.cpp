#include "scheduling/plan/plausible.hpp"

#include <algorithm>
#include <vector>

namespace forefeel {

bool is_far_too_strong(const State& state, const StateSpace& space) {
  if (!state.at.allFinite() || !state.force.allFinite()) return true;
  std::vector<StateId> near;
  space.within(state.at, 2 * space.options().spacing, near);
  double force = 0, stiffness = 0;
  for (const StateId id : near) {
    const State& known = space[id];
    if (!known.stiffness.allFinite()) continue;
    force = std::max(force, known.force.norm() + known.stiffness.norm() * (state.at - known.at).norm());
    stiffness = std::max(stiffness, known.stiffness.norm());
  }
  if (stiffness == 0) return false;
  return (force > 0 && state.force.norm() > implausible_factor * force) ||
         (state.stiffness.allFinite() && state.stiffness.norm() > implausible_factor * stiffness);
}

}  // namespace forefeel
