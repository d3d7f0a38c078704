#pragma once
// Counts and extremes of a set of states: what `forefeel info` and `forefeel import` say about it.

#include <cstddef>
#include <map>
#include <span>
#include <string>

#include "geometry/states/repeated_states.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

struct StateSetSummary {
  std::size_t states = 0, usable = 0;
  std::map<std::string, std::size_t> by_status;  // name(outcome) -> number
  std::size_t with_stiffness = 0, with_energy = 0, with_displacements = 0,
              with_jet = 0;  // of the usable ones
  std::size_t multivalued = 0;
  std::size_t inverted = 0;  // of the usable ones: with inverted elements
  RepeatedStates at_one_position;
  Box extent;                // of all positions [m]; zero without states
  double max_force = 0;      // of the usable ones [N]
  double solve_seconds = 0;  // in all [s]
};

StateSetSummary summarise(std::span<const State> states);

// Median distance to the nearest state at another position, of at most 200 states spread over the set [m]; infinite
// for fewer than two positions. O(200 n).
double typical_distance(std::span<const State> states);

}  // namespace forefeel
