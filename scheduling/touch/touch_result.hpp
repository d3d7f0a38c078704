#pragma once
// What a touch session is given, and its result.

#include <filesystem>
#include <functional>

#include "approx/switch/relaxation.hpp"
#include "geometry/states/state_header.hpp"
#include "scheduling/common/session_result.hpp"
#include "scheduling/touch/session_surface.hpp"
#include "scheduling/touch/touch_planner.hpp"
#include "scheduling/touch/touch_records.hpp"

namespace forefeel {

class RankPool;

struct TouchSessionInput {
  TouchTask task;
  double site_spacing = 0;          // for labels [m]
  BodyIdentity identity;            // of the file of states
  Viscosity viscosity;              // of the body
  DrawPlaces draw;                  // for paths of the hand
  std::vector<State> known;         // at the start
  std::filesystem::path folder;     // of the scene, for files of motions
  std::filesystem::path states;     // new states are appended here; empty: nowhere
  std::shared_ptr<RankPool> ranks;  // that solve in place of threads, real clock
};

struct TouchProgress {
  double done = 0, whole = 1;  // seconds of the session, or references
  bool references = false;
  std::size_t known = 0;
  std::size_t rehearsal = 0,
              rehearsals = 0;  // schedule that is simulated in advance, and of how many; 0: none
};

struct TouchSessionResult {
  std::vector<TouchFrameRecord> frames;
  std::vector<TouchDispatch> dispatches;
  std::vector<std::shared_ptr<const DeepStates>> models;  // by serial number - 1
  std::vector<State> states;  // all known at the end; those known at the start come first
  std::size_t known_at_start = 0, failed = 0;
  SafetyReport safety;
  LoopReport loop;
  bool interrupted = false;
  std::size_t references_failed = 0;
  std::vector<std::string> notes;
};

}  // namespace forefeel
