#pragma once
// States of the field of measured forces (measured/force_field.hpp), for a model that renders them.
//
// A model through measured forces takes their noise for slope: between rows a micrometre apart, a noise of 0.02 N is a
// stiffness of 20,000 N/m. So some of the rows stay, at least a share of h from each other, each with the force f~ of
// the field of all rows and its stiffness
//   K = -df~/dx, by central differences over a step far below h.
// Across a line of rows the field is that of the line, so K is 0 there.

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "approx/model/model_options.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

struct FieldStates {
  std::vector<State> states;
  FieldOptions field = {};  // of the measured forces: EvaluateOptions::field
};

// measured: usable states without stiffness, one at each position. spacing: h [m]. show: called by one thread with the
// share done. Nothing if the states have no field (field_law.hpp). Some milliseconds a state.
std::optional<FieldStates> field_states(std::span<const State> measured, double spacing,
                                        const std::function<void(double)>& show = {});

}  // namespace forefeel
