#pragma once
// The states that a session knows at its start, and the file of those that it solves.

#include <filesystem>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/scene/scene.hpp"
#include "apps/session/session_arguments.hpp"

namespace forefeel {

// The plan with the states known at the start, and the file for those that will be solved: `own` of the run (empty:
// none), unless the given one is to be extended.
SessionPlan take_states(const Scene& scene, const KnownStatesArguments& states,
                        const std::filesystem::path& own, const Globals& globals, SessionPlan plan);
// The plan with these states of another body, which alone are rendered. name: of where they come from.
SessionPlan take_foreign(const Scene& scene, const std::string& name, std::vector<State> given,
                         const Globals& globals, SessionPlan plan);

}  // namespace forefeel
