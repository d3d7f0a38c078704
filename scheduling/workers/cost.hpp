#pragma once
// What a solve costs under the virtual clock [s].
//
// To write a model: derive from CostModel, define seconds(), register it under a name.
//
//   struct Deeper final : forefeel::CostModel {                   // the deeper, the dearer
//     double least; explicit Deeper(double s) : least(s) {}
//     double seconds(const forefeel::Vec3& at) const override { return least * (1 + 100 * at.norm()); }
//   };
//   const bool known = (forefeel::register_cost("deeper", [](forefeel::FactoryContext& with) {
//     return std::make_unique<Deeper>(with.arguments.number("least", 0.01, 1e-6, 10)); }), true);
//
// Scenes (session.cost), studies and --cost then know it as "deeper" and "deeper:least=0.02".
//
// Order of calls: before the session for a coarse grid of positions, whose median is the planner's first guess; then once
// for each state that is dispatched. Thread: that of the session.
// The cost must be a function of position and seed alone, so that every policy pays the same for the same state and a run
// repeats bit by bit. At least a nanosecond is charged.
//
// The state at rest, where a session asks for it as what it is (PlanningOptions::rest_first), is known to be in
// equilibrium: no iteration, one factorisation for its stiffness. `recorded` charges what the solver was measured to take
// for it. The others charge a fourth of seconds(), one of the iterations that a state takes: full Newton to 1e-6 took 3.0
// on average from a parent 6 mm away, 4.7 from 12 mm, 5.6 from 24 mm and 7.4 from rest (liver phantom, 48 random positions
// of its box; St. Venant-Kirchhoff 6.2 to 10).

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
  virtual double seconds(const Vec3& at) const = 0;  // of the state at that position from a neighbour
  virtual double rest_seconds() const;               // of the state at rest, asked for as such
};

struct RecordedCosts {
  std::vector<double> solves;  // from a neighbour [s]
  double rest = 0;             // of the state at rest [s]
};

using CostFactory = std::function<std::unique_ptr<CostModel>(FactoryContext&)>;

// From any thread and also before main() begins. InputError for a name that is taken, those of built-in models included.
void register_cost(const std::string& name, CostFactory factory);
std::vector<std::string> registered_costs();  // sorted, without the built-in ones

// recorded: the measured times; called for RecordedCost alone. InputError for a value outside its range and for a name
// that nobody registered.
std::unique_ptr<CostModel> make_cost(const CostSpec& cost, const FactoryContext& context,
                                     const std::function<RecordedCosts()>& recorded);

// "constant:SECONDS, lognormal:MEDIAN,SIGMA, recorded or paper", and the registered ones: what is expected where a model
// is unknown.
std::string cost_kinds();

}  // namespace forefeel
