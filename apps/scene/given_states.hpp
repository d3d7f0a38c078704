#pragma once
// States that a command gets in addition to a scene. They must belong to the scene's body:
//   identity   the file names its body, and it is the body of the scene
//   asked      the file names no body (a CSV, imported or measured states). The body is solved at a few of the file's
//              positions, and the forces agree (scheduling/workers/ask_body.hpp)
//   foreign    with --foreign, states of any body are accepted; then nothing is solved for the scene's body

#include <string>

#include "apps/console/console.hpp"
#include "apps/scene/scene.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {

enum class Belonging { identity, asked, foreign };
std::string_view name(Belonging belonging);

struct GivenStates {
  LoadedStates loaded;
  Belonging belonging = Belonging::identity;
};

// Reads the file and never writes to it. InputError if the states belong to another body, unless `foreign`; the error
// names what differs, in the identity or in the forces. Warns of damaged rows. Averages states that contradict each
// other at one position.
GivenStates given_states(const Globals& globals, const Scene& scene, const std::string& file, bool foreign);

// The same for states that are already loaded from `file`.
Belonging belonging_of(const Globals& globals, const Scene& scene, const std::string& file,
                       const BodyIdentity& identity, std::span<const State> states, bool foreign,
                       bool may_be_foreign = true);  // of a command that has --foreign

// Help of the option --foreign.
extern const char* const foreign_help;

}  // namespace forefeel
