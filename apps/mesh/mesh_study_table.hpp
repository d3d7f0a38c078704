#pragma once
// forefeel mesh SCENE.toml --study -o DIR/: the scene's force against the number of elements, linear and
// quadratic (solver/equilibrium/mesh_study.hpp), as table, CSV and picture, and the cheapest body below an
// error. The reference comes from the scene's mesh and its refinements (solver/body/refined_body.hpp), which have the
// same contact. A surface or phantom (synthetic body) is also meshed anew, with a quarter to four times its elements,
// unless clamp or contact name nodes. The errors of these meshes include the change of the contact.

#include <string>
#include <vector>

#include "apps/console/console.hpp"

namespace forefeel {

struct MeshStudyArguments {
  std::string scene, folder;
  double error = 0.02;  // wanted [1]
};

// Returns 1 if no body that was tried is below the error, or too few could be solved to decide.
int study_meshes(const Globals& globals, const MeshStudyArguments& arguments);

}  // namespace forefeel
