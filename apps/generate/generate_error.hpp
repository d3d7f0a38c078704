#pragma once
// forefeel generate --error E: solves as few states as needed to keep the estimated error below E
// (scheduling/placement/placement.hpp).

#include <optional>
#include <string>

#include "apps/console/console.hpp"
#include "apps/scene/scene.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {

// Throws InputError if no model with that many neighbours can be made. Called before any file is written.
void check_generate_to_error(const Scene& scene);

// Appends the states to the open file. Returns the exit code. error must be positive and finite; without it as many
// states are placed as the other designs have (design_size()).
int generate_to_error(const Globals& globals, const Scene& scene, StateFile file, const std::string& output,
                      std::optional<double> error);

}  // namespace forefeel
