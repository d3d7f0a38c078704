#pragma once
// How a session chooses the next states to solve.

#include <filesystem>
#include <optional>

#include "scheduling/policy/policy.hpp"

namespace forefeel {

struct PlanningOptions {
  PolicySpec policy = "coverage";
  Placement placement = Placement::lattice;  // where states may be placed
  bool preempt = true;                       // cancel a running solve if another is worth far more
  // If no state is known, solve the state at rest first. Its force is zero and its stiffness takes one factorisation
  // (scheduling/workers/cost.hpp), so it is ready long before any other state. The first model is then the tangent of
  // the body at rest.
  bool rest_first = true;
  // The state at rest is known from the start: the tangent of the body is rendered at once, without a fade-in
  // from zero.
  bool rest_known = false;
  // States per job, 1 to 8: the chosen state and neighbours solved with its factorisation. 0 means 8 under
  // the real clock and 1 under the virtual clock, whose cost models describe single solves.
  int batch = 0;
  // Share of the solves that are audits: solved where the HIP has just been, to calibrate the error bars
  // (render/bar_keeper.hpp). Models of method rbf only.
  double audit = 0.03;
  // A file CSV t,x,y,z, rows in any order. States become known at these times; nothing is dispatched.
  std::optional<std::filesystem::path> arrivals = {};
};

// Throws InputError with the key of an invalid value.
void check(const PlanningOptions& options);

}  // namespace forefeel
