#pragma once
// States that stand where another one stands: all but one of them are passed over.

#include <span>

#include "geometry/states/state.hpp"

namespace forefeel {

// Two usable states of one position whose forces differ by more than 1e-6 of the larger one, which is more than two
// solves of one state leave.
bool contradict(const State& a, const State& b);

struct RepeatedStates {
  std::size_t repeated = 0;       // at the position of one before them
  std::size_t contradicting = 0;  // usable ones that contradict the first usable one of their position
};
RepeatedStates repeated_states(std::span<const State> states);

}  // namespace forefeel
