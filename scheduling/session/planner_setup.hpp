#pragma once
// Settings and parts of a planner.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "approx/switch/force_switch.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/render/session_model_options.hpp"
#include "scheduling/session/planning_options.hpp"

namespace forefeel {

// Of the touched body.
struct PlannedBody {
  std::size_t nodes = 0;         // of its mesh; limits how many solutions are kept as starts
  Mat3 stiffest = Mat3::Zero();  // K_b, bound of its stiffness at rest [N/m] (plausible.hpp); zero: unknown
};

class SurfaceModels;

struct PlannerSetup {
  StateSpaceOptions space = {};
  std::span<const State> known =
      {};  // at the start; failed states are not tried again. Read by the constructor only
  PlannedBody body = {};
  PlanningOptions options = {};  // with a batch of at least 1
  std::shared_ptr<Policy> policy = {};
  std::shared_ptr<Predictor> predictor = {};
  double latency = 0;  // of a message to or from a worker [s]
  ModelRecipe model = {};
  SwitchOptions jnd = {};  // unit of PlannerView::surprises
  std::uint64_t seed = 0;  // of the choice of audits
  // Of a body that may be touched anywhere: positions are those of the tip, and states have a site. Null: one place.
  std::shared_ptr<SurfaceModels> surface = {};
};

}  // namespace forefeel
