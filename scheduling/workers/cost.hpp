#pragma once
// The time that a solve takes under the virtual clock [s].
//
// To write a model: derive from CostModel, define seconds(), register it under a name.
//
//   struct Deeper final : forefeel::CostModel {                   // deeper states cost more
//     double least; explicit Deeper(double s) : least(s) {}
//     double seconds(const forefeel::Vec3& at) const override { return least * (1 + 100 * at.norm()); }
//   };
//   const bool known = (forefeel::register_cost("deeper", [](forefeel::FactoryContext& with) {
//     return std::make_unique<Deeper>(with.arguments.number("least", 0.01, 1e-6, 10)); }), true);
//
// In code, options.workers.cost = Registered("deeper") then selects it. Scenes, studies and options
// know the name only in a command built with it (apps/examples/command_policy.cpp); `forefeel` itself is not.
//
// Order of calls: before the session for a coarse grid of positions, whose median is the planner's first estimate; then
// once for each dispatched state. Thread: that of the session. The cost must depend only on position and seed: then a
// state costs the same under every policy, and runs repeat bit by bit. The least cost is a nanosecond.
//
// The state at rest is cheaper if the session requests it as such (PlanningOptions::rest_first): it is in equilibrium,
// so it takes no iteration, only one factorisation for its stiffness. The model `recorded` uses its measured time. The
// other models use a quarter of seconds(): one of about four Newton iterations per state. Measured iterations of full
// Newton to 1e-6: 3.0 on average from a state 6 mm away, 4.7 from 12 mm, 5.6 from 24 mm, 7.4 from rest (liver phantom,
// 48 random positions of its box; St. Venant-Kirchhoff 6.2 to 10).

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "geometry/common/types.hpp"
#include "scheduling/common/factory_context.hpp"
#include "scheduling/workers/cost_spec.hpp"

namespace forefeel {

class CostModel {
 public:
  virtual ~CostModel() = default;
  virtual double seconds(const Vec3& at) const = 0;  // of the state there, solved from a neighbour
  virtual double rest_seconds() const;               // of the state at rest, requested as such
};

// cost.seconds(at), or cost.rest_seconds() for the state at rest. InputError if the result is NaN or negative.
// Sessions call the model through these functions; a running session then ends early.
double checked_seconds(const CostModel& cost, const Vec3& at);
double checked_rest_seconds(const CostModel& cost);

struct RecordedCosts {
  std::vector<double> solves;  // from a neighbour [s]
  double rest = 0;             // of the state at rest [s]
};

using CostFactory = std::function<std::unique_ptr<CostModel>(FactoryContext&)>;

// May be called from any thread, and before main() begins. InputError for a name that is taken or built in.
void register_cost(const std::string& name, CostFactory factory);
std::vector<std::string> registered_costs();  // sorted, without the built-in ones

// recorded: returns the measured times; called for RecordedCost only. InputError for a value outside its
// range or an unregistered name.
std::unique_ptr<CostModel> make_cost(const CostSpec& cost, const FactoryContext& context,
                                     const std::function<RecordedCosts()>& recorded);

// The accepted models, for the error message about an unknown one: "constant:SECONDS, lognormal:MEDIAN,SIGMA,
// recorded or paper", then the registered names.
std::string cost_kinds();

}  // namespace forefeel
