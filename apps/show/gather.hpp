#pragma once
// Reads the input of `forefeel show`: a scene, a mesh, a surface, a set of states, or the folder of a run.

#include <optional>
#include <string>

#include "apps/console/console.hpp"
#include "apps/show/show_content.hpp"

namespace forefeel {

struct ShowRequest {
  std::string what;  // file or folder
  std::string
      scene;  // the scene of states or of a run; empty: that of the run's own command, if it still exists
  bool foreign = false;              // states of another body beside the scene
  std::optional<double> trust = {};  // depth at which a body touched anywhere is coloured by its error [m]
};

// InputError for a file that is missing, damaged or of another kind, and for states of another body.
ShowContent gather(const Globals& globals, const ShowRequest& request);

}  // namespace forefeel
