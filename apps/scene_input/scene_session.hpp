#pragma once
// From a scene to what a session runs on.

#include "apps/scene_input/scene.hpp"
#include "scheduling/session/session_input.hpp"

namespace forefeel {

// The scene's body, box and spacing; no known states, no state file; references are kept in the cache folder,
// and files that the scene names are sought beside it.
SessionInput session_input(const Scene& scene);

}  // namespace forefeel
