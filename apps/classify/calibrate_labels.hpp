#pragma once
// `forefeel classify [STATES] --calibrate SCENE [-o DIR/]`: error statistics per label on this body.

#include <string>

#include "apps/console/command.hpp"

namespace forefeel {

// states: a file; "" uses the lattice of the scene. Returns the exit code.
int calibrate_labels(const Globals& globals, const std::string& scene, const std::string& states,
                     const std::string& output);

}  // namespace forefeel
