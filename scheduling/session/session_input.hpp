#pragma once
// What a session is given besides its options: the body, the states that are known, and where files are.

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state_file.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/generator.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// What is touched: a body, how its files know it again, and the space that its states lie in.
struct TouchedBody {
  std::shared_ptr<const Body> body = {};
  BodyIdentity identity = {};    // empty: no file of its states is kept in the cache
  StateSpaceOptions space = {};  // box and spacing of the states
  bool displacements = false;    // states hold the displacements of all nodes
  Vec3 inward = -Vec3::UnitZ();  // from the contact into the body
};

struct SessionFiles {
  std::optional<std::filesystem::path> states = {};  // new states are appended here
  std::filesystem::path cache = {};                  // folder of this body's tight solves; empty: none
  std::filesystem::path scene = {};                  // folder where relative trace files are looked up
};

// Parts given as objects. Each takes the place of the one that the options name. An object serves one session
// at a time; predictor and workers serve one session only.
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
  SessionFiles files = {};
  SessionParts parts = {};
  // One service for many sessions of the same body, spacing and displacements, also at the same time, since a
  // cache file has one writer. Null: the session makes its own in files.cache.
  std::shared_ptr<ReferenceService> references = {};
};

// What a service of reference solves needs to know of this input.
ReferenceOptions reference_options(const SessionInput& input);

}  // namespace forefeel
