#pragma once
// Makes the input and the options of a session from a scene.

#include "apps/scene/scene.hpp"
#include "scheduling/session/session_input.hpp"
#include "scheduling/session/session_options.hpp"

namespace forefeel {

// The scene's body, box and spacing, without known states or a state file. References are kept in the cache
// folder. Relative file names in the scene are relative to the scene file.
SessionInput session_input(const Scene& scene);

// All of [session]. Throws InputError("device TEXT: …") if the device or the cost cannot be read.
SessionOptions session_options(const Scene& scene);
// Device and cost are read late, so that a command without a session accepts a scene with a wrong device.
DeviceSpec device_of(const Scene& scene);
CostSpec cost_of(const Scene& scene);

}  // namespace forefeel
