#pragma once
// forefeel generate --error E: as few states as hold the estimated error below E (scheduling/placement/placement.hpp).

#include "apps/console/console.hpp"
#include "apps/scene_input/scene.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {

// InputError where a model of that many neighbours cannot be made; before a file is touched.
void check_generate_to_error(const Scene& scene);

// Appends to the open file; the exit code. error is positive and finite.
int generate_to_error(const Globals& globals, const Scene& scene, StateFile file, const std::string& output,
                      double error);

}  // namespace forefeel
