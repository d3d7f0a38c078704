#pragma once
// From a scene to what a session runs on.

#include "apps/scene_input/scene.hpp"
#include "scheduling/session/session_input.hpp"
#include "scheduling/session/session_options.hpp"

namespace forefeel {

// The scene's body, box and spacing; no known states, no state file; references are kept in the cache folder,
// and files that the scene names are sought beside it.
SessionInput session_input(const Scene& scene);

// [session], whole. InputError("device TEXT: …") for a device or a cost that cannot be read.
SessionOptions session_options(const Scene& scene);
// The two that are read late: a command that needs no session accepts a scene whose device is wrong.
DeviceSpec device_of(const Scene& scene);
CostSpec cost_of(const Scene& scene);

}  // namespace forefeel
