#pragma once
// `forefeel classify [STATES] --calibrate SCENE [-o DIR/]`: error statistics per label on this body.

#include <string>

#include "apps/console/command.hpp"

namespace forefeel {

struct CalibrateArguments {
  std::string scene;
  std::string states;    // a file; "" uses the lattice of the scene
  bool foreign = false;  // states of another body: nothing is solved, a part of them is used as truth
  std::string output;    // folder; "": none
};

// Returns the exit code.
int calibrate_labels(const Globals& globals, const CalibrateArguments& arguments);

}  // namespace forefeel
