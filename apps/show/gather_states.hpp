#pragma once
// The states of a picture, and labels on a grid for its cut planes.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "apps/classify/classify.hpp"
#include "apps/show/show_content.hpp"

namespace forefeel {

// What labels are made with. box: nothing where only the states' extent is known.
struct LabelFrame {
  std::string where;  // what errors name
  double spacing = unknown;
  std::optional<Box> box;
};

// Labels of every place are taken at the end of `times` and at the others [s]; a state is known from the time
// `known` on, or from the start where that is NaN. Sets states, box and spacing of the content.
void take_states(const Globals& globals, const LabelFrame& frame, std::vector<ShownState> states,
                 std::span<const double> times, ShowContent& content);

}  // namespace forefeel
