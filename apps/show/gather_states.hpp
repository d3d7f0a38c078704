#pragma once
// The states of a picture, and labels on a grid for its cut planes.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "apps/offline/classify.hpp"
#include "apps/show/show_content.hpp"

namespace forefeel {

// Settings of the labels. box: nullopt if only the extent of the states is known.
struct LabelFrame {
  std::string where;         // what errors name
  double spacing = unknown;  // [m]
  std::optional<Box> box;
};

// Computes labels on a grid at each of `times` [s]. A state counts from its time `known` on, or from the start if that
// is NaN. Sets states, box and spacing of the content.
void take_states(const Globals& globals, const LabelFrame& frame, std::vector<ShownState> states,
                 std::span<const double> times, ShowContent& content);

}  // namespace forefeel
