#pragma once
// Reads the input of `forefeel show`: a scene, a mesh, a surface, a set of states, or the folder of a run.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/offline/classify.hpp"
#include "apps/show/show_content.hpp"

namespace forefeel {

// The states of a picture, and labels on a grid for its cut planes.

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
