#pragma once
// Duplicate positions among states. Only the first state of a position is used.

#include <span>

#include "geometry/states/state.hpp"

namespace forefeel {

// Two usable states at one position contradict each other if their forces differ by more than 1e-6 of the
// larger one. Two tight solves of one state differ by less.
bool contradict(const State& a, const State& b);

struct RepeatedStates {
  std::size_t repeated = 0;       // at the position of an earlier state
  std::size_t contradicting = 0;  // usable states that contradict the first usable state at their position
};
RepeatedStates repeated_states(std::span<const State> states);

}  // namespace forefeel
