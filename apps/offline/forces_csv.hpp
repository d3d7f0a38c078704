#pragma once
// What `evaluate -o` writes: a row for each point.

#include <string>
#include <vector>

#include "approx/methods/evaluate.hpp"

namespace forefeel {

// value: name of what the states tell instead of a force; empty: a force.
void write_forces(const std::string& file, const std::vector<Vec3>& points, const Evaluation& found,
                  const std::string& value = {});

}  // namespace forefeel
