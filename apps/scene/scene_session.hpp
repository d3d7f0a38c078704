#pragma once
// Makes the input and the options of a session from a scene.

#include <optional>
#include <vector>

#include "apps/console/document_keys.hpp"
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

// ---- of a scene with contact.anywhere = true

struct Globals;

// The field of the body, in the summary.
struct SessionField {
  std::size_t sites = 0;
  double spacing = 0, depth = 0;    // of sites; to which states are placed [m]
  double seconds = 0, patches = 0;  // that making or reading it, and its facets, took [s]
  bool kept = false;                // it was read from the cache
  std::optional<double> friction = {};
};
const JsonKeys<SessionField>& session_field_keys();

// Makes the session touch the scene's body anywhere: finds the field, in the cache or by solving. Nothing of a scene
// with one place of contact. like: of the same body, whose field is taken; null: none.
std::optional<SessionField> touch_anywhere(const Scene& scene, const Globals& globals, SessionInput& input,
                                           const SessionInput* like = nullptr);
// Where the scene says no motion: a palpation. Pressing at one place is no use of such a scene.
void palpate(const Scene& scene, bool own_device, SessionOptions& options);

// Of these the states of a touched body that a session may know, without the jets of its field, which files of
// `generate` hold too.
std::vector<State> states_for_touch(const SessionInput& input, std::vector<State> states);

}  // namespace forefeel
