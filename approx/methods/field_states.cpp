#include "approx/methods/field_states.hpp"

#include <omp.h>

#include "approx/measured/field_law.hpp"
#include "approx/measured/force_field.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {
namespace {

constexpr double apart_share = 0.25;  // of h, between states that stay
constexpr double step_share = 0.02;   // of h, of the differences

// Those at least `apart` from all before them.
std::vector<State> spread_out(std::span<const State> measured, double apart) {
  StateSpace kept({.spacing = apart});
  std::vector<State> states;
  std::vector<StateId> near;
  for (const State& row : measured) {
    kept.within(row.at, apart, near);
    if (!near.empty()) continue;
    State state;
    state.at = row.at;
    state.force = row.force;
    kept.insert(state);
    states.push_back(std::move(state));
  }
  return states;
}

}  // namespace

std::optional<FieldStates> field_states(std::span<const State> measured, double spacing,
                                        const std::function<void(double)>& show) {
  const std::optional<FieldOptions> options = field_of(measured);
  if (!options) return {};
  StateSpace known({.spacing = spacing});
  for (const State& state : measured) known.insert(state);
  const ForceField field(known, *options);
  FieldStates made{.states = spread_out(measured, apart_share * spacing), .field = *options};
  std::size_t done = 0;
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t i = 0; i < made.states.size(); ++i) {
    State& state = made.states[i];
    const ForceField::Linear made_there = field.linear(state.at, step_share * spacing);
    state.force = made_there.force;
    state.stiffness = made_there.stiffness;
    std::size_t now = 0;
#pragma omp atomic capture
    now = ++done;
    if (show && omp_get_thread_num() == 0)
      show(static_cast<double>(now) / static_cast<double>(made.states.size()));
  }
  return made;
}

}  // namespace forefeel
