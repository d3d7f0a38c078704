#pragma once
// The input of a session besides its options: the body, the known states, files and parts given as objects.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "approx/model/model_options.hpp"
#include "approx/switch/relaxation.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state_header.hpp"

namespace forefeel {

class RestSites;  // solver/jet/rest_sites.hpp

class CostModel;
class Device;
class Policy;
class Predictor;
class RealWorkers;
class ReferenceService;
class VirtualWorkers;
struct Body;
struct ReferenceOptions;
struct TouchTask;  // touch/surface_models.hpp

// The touched body, the identity that its files carry, and the space of its states.
struct TouchedBody {
  std::shared_ptr<const Body> body = {};
  BodyIdentity identity = {};    // empty: its states are not cached on disk
  StateSpaceOptions space = {};  // box and spacing of the states
  bool displacements = false;    // states hold the displacements of all nodes
  int jet = 1;                   // order of the force that states keep: with 2 to 4 also an energy jet
  Vec3 inward = -Vec3::UnitZ();  // from the contact into the body
  Viscosity viscosity = {};      // of all its tissue; states are elastic and do not depend on it
  // Set: the body may be touched anywhere (touch/touch.hpp). Positions are those of the tip in the axes of the mesh,
  // `space` is a box of the tip, and states have a site. Null: one place of contact.
  std::shared_ptr<const TouchTask> anywhere = {};
};

struct SessionFiles {
  std::optional<std::filesystem::path> states = {};  // new states are appended here
  std::optional<std::filesystem::path> inputs =
      {};                            // inputs of the run are recorded here (render/input_log.hpp)
  std::string program = {};          // name and version of the recording program
  std::filesystem::path cache = {};  // folder of this body's tight solves; empty: none
  std::filesystem::path scene = {};  // folder where relative trace files are looked up
};

// Parts given as objects. Each replaces the part named in the options. An object serves one session at a
// time; a predictor or workers object serves one session only.
struct SessionParts {
  std::shared_ptr<Device> device = {};
  std::shared_ptr<Policy> policy = {};
  std::shared_ptr<Predictor> predictor = {};
  std::shared_ptr<const CostModel> cost = {};            // virtual clock
  std::shared_ptr<RealWorkers> workers = {};             // real clock
  std::shared_ptr<VirtualWorkers> virtual_workers = {};  // virtual clock
};

struct SessionInput {
  TouchedBody touched = {};
  std::vector<State> known = {};  // at the start
  // The known states are those of another body, or of a body without a model, such as measured forces. The session
  // renders them alone: it solves neither states nor references, and writes no state file.
  bool foreign = false;
  std::vector<State> measured = {};  // whose field the known states are (approx/methods/field_states.hpp)
  std::optional<FieldOptions> measured_field = {};  // the law of that field
  SessionFiles files = {};
  SessionParts parts = {};
  // A service shared by sessions of the same body, spacing and displacements, which may run at the same time.
  // Sharing is necessary because a cache file has one writer. Null: the session makes its own service in
  // files.cache.
  std::shared_ptr<ReferenceService> references = {};
};

// The options of a reference service for this input (workers/reference_service.hpp).
// Of a body that is touched anywhere; else null.
std::shared_ptr<const RestSites> sites_of(const TouchedBody& touched);
ReferenceOptions reference_options(const SessionInput& input);

}  // namespace forefeel
