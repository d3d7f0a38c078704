#pragma once
// What is solved next.

#include <filesystem>
#include <optional>

#include "scheduling/policy/candidates.hpp"

namespace forefeel {

struct PlanningOptions {
  PolicySpec policy = "coverage";
  Placement placement = Placement::lattice;  // where states may be placed
  bool preempt = true;                       // a running solve is cancelled where another is worth far more
  // The first job of a session that knows nothing is the state at rest: its force is zero, its stiffness one
  // factorisation (cost.hpp). It is there long before any other, and the first model is the body's tangent at
  // rest.
  bool rest_first = true;
  // Rest is known from the start: the hand feels the body's tangent at once, and nothing fades in from zero.
  bool rest_known = false;
  // States of one job: the chosen one and its neighbours, solved on its factor, 1 to 8. 0: 8 in real time and
  // 1 under the virtual clock, whose cost models know single solves.
  int batch = 0;
  // CSV t,x,y,z, rows in any order: states become known at given times, nothing is dispatched.
  std::optional<std::filesystem::path> arrivals = {};
};

// InputError names the key of a value that cannot be used.
void check(const PlanningOptions& options);

}  // namespace forefeel
