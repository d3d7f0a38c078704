#pragma once
// States that a command is given beside a scene, and how it is known that they belong to the scene's body:
//   identity   the file names its body, and it is the scene's
//   asked      it names none (a CSV, imported or measured states): the body is solved at a few of the file's
//              positions, and the forces agree (scheduling/workers/ask_body.hpp)
//   foreign    --foreign: they are taken as they are, and nothing may be solved for the scene's body beside
// them

#include <string>

#include "apps/console/console.hpp"
#include "apps/scene_input/scene.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {

enum class Belonging { identity, asked, foreign };
std::string_view name(Belonging belonging);

struct GivenStates {
  LoadedStates loaded;
  Belonging belonging = Belonging::identity;
};

// Reads the file; nothing is written to it. InputError where the states are of another body, unless they are
// taken as foreign: what differs, in the identity or in the forces. Warns of damaged rows, and averages
// states that contradict each other at one position.
GivenStates given_states(const Globals& globals, const Scene& scene, const std::string& file, bool foreign);

// The same for states that are already loaded from `file`.
Belonging belonging_of(const Globals& globals, const Scene& scene, const std::string& file,
                       const BodyIdentity& identity, std::span<const State> states, bool foreign);

// Help of the option --foreign.
extern const char* const foreign_help;

}  // namespace forefeel
