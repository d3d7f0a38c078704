#pragma once
// A scene (TOML): body, material, clamp, contact, state space, model, session. Unknown keys are errors that
// suggest the nearest known one; every error names file, key and what was expected.

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/scene/scene_accuracy.hpp"
#include "apps/scene/scene_spacing.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/tolerance.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/shape/shape_log.hpp"

namespace forefeel {

// The text that a scene was read from.
struct SceneSource {
  std::filesystem::path file;
  std::string hash;  // of the scene as overridden, without comments
  std::string body;  // the sections that make the body, as text
  std::vector<std::string> warnings;
  std::optional<AccuracyChoice> accuracy = {};  // with body.accuracy: the body that was chosen
};

// Values that depend on whether, and where, the scene gives a key: liver.toml:30: session.device.
struct SceneWritten {
  std::optional<std::string> device, cost;  // as written; nullopt if the scene does not give the key
  std::optional<Tolerance> tolerance = {};  // state_space.tolerance
  // arrivals_place is empty if the scene gives no arrivals.
  InputPlace device_place = {}, cost_place = {}, box_place = {}, arrivals_place = {};
  // Keys of [session] that only control what is solved, each with its place. They have no effect if states arrive at
  // given times.
  std::vector<std::pair<std::string, InputPlace>> scheduling;
};

inline constexpr double usual_tolerance = 0.07;  // state_space.tolerance where the scene gives none [1]

struct SceneSpacing {
  bool automatic = false;  // spacing = "auto"
  // Tolerance of the relative error where the label is safe (densely known) [1]; spacing = "auto" meets it.
  double tolerance = usual_tolerance;
  std::optional<SpacingChoice> chosen;  // with spacing = "auto" only, if it was measured
};

// What a state keeps beside its force, stiffness and energy.
struct KeptValues {
  bool displacements = false;
  int jet = 1;  // order of the force: with 2 to 4 also an energy jet
};

inline constexpr double usual_depth = 0.025;  // state_space.depth where the scene gives none [m]

struct FineBodies;  // scene_fine.hpp

// What a scene with contact.anywhere = true says beside its pad.
struct AnywhereKeys {
  double depth = usual_depth;                   // to which states are placed [m]
  std::optional<double> friction = {};          // coefficient; nullopt: bonded, the site never moves
  std::optional<double> site_spacing = {};      // [m]; nullopt: chosen
  std::shared_ptr<const FineBodies> fine = {};  // their pads stand anywhere; null: no fine body
};

// How the body answers beside its equilibria at one place.
struct SceneTouch {
  Viscosity viscosity = {};              // of all materials
  std::optional<AnywhereKeys> anywhere;  // with contact.anywhere = true
};

struct Scene {
  SceneSource source;
  SceneWritten written;
  std::shared_ptr<const Body> body;  // checked: it can be solved
  BodyIdentity identity;             // mesh, material, clamp, contact -> hash
  SceneTouch touch = {};
  Vec3 inward = -Vec3::UnitZ();  // from the contact into the body
  StateSpaceOptions space;
  SceneSpacing spacing;
  KeptValues kept;
  ModelOptions model;
  SessionOptions session;  // .model.fit equals model; device and cost: scene_session.hpp
  ShapeOptions shape;      // a rate above 0 makes states keep their displacements
};

// How a command uses its scene. Measuring spacing = "auto" solves hundreds of states.
struct SceneUse {
  bool spacing = true;  // false: "auto" is not measured; the finest spacing that would be tried is used
  bool quiet = false;   // no progress line while it is measured
};

// overrides: "key.path=value" as given to --set; value is TOML, or a bare string.
// like: another variant of the same file. If both describe the same body, the body is shared instead of
// meshed again.
Scene load_scene(const std::filesystem::path& file, std::span<const std::string> overrides = {},
                 const Scene* like = nullptr, const SceneUse& use = {});

// The built-in scene of commands that are given none: the liver phantom (synthetic body), grasped on its right lobe by
// a patch of 2 cm; neo-Hookean, spacing 6 mm.
Scene built_in_scene(std::span<const std::string> overrides = {});
std::string_view built_in_scene_text();
// A scene that a command brings as text; name stands for the file in messages.
Scene scene_of_text(std::string_view text, const std::string& name,
                    std::span<const std::string> overrides = {}, const SceneUse& use = {});

// Full paths of the keys that the reader asks for in a scene with this text, for the test that every declared
// key is read.
std::set<std::string> scene_keys_read(std::string_view text, std::span<const std::string> overrides = {});

// The scene's state space on a lattice of another spacing [m]. If the scene gives no box, the box changes with the
// spacing. InputError if the lattice has too many positions.
StateSpaceOptions space_at(const Scene& scene, double spacing);

}  // namespace forefeel
