#include "scheduling/session/plausible.hpp"

#include <algorithm>
#include <vector>

namespace forefeel {
namespace {

bool beyond_the_body(const State& state, double spacing, double stiffest) {
  const double distance = state.at.norm();
  const double most = (distance < 1e-9 * spacing ? implausible_at_rest : implausible_factor) * stiffest;
  return state.force.norm() > most * std::max(distance, spacing) ||
         (state.stiffness.allFinite() && state.stiffness.norm() > most);
}

}  // namespace

bool is_far_too_strong(const State& state, const StateSpace& space, const Mat3& stiffest) {
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
  if (stiffness == 0)
    return !stiffest.isZero(0) && beyond_the_body(state, space.options().spacing, stiffest.norm());
  return (force > 0 && state.force.norm() > implausible_factor * force) ||
         (state.stiffness.allFinite() && state.stiffness.norm() > implausible_factor * stiffness);
}

}  // namespace forefeel
