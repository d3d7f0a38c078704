#pragma once
// The states that a session knows at its start, and the file of those that it solves.

#include "apps/console/console.hpp"
#include "apps/scene/scene.hpp"
#include "apps/session/session_arguments.hpp"

namespace forefeel {

// The plan with the states known at the start, and the file for those that will be solved: the run's own,
// unless the given one is to be extended.
SessionPlan take_states(const Scene& scene, const SessionArguments& given, const Globals& globals,
                        SessionPlan plan);

}  // namespace forefeel
