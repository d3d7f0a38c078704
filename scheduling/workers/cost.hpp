#pragma once
// What a solve costs under the virtual clock [s]:
//   constant:S             always S
//   lognormal:MEDIAN,SIGMA exp(ln MEDIAN + SIGMA n), n standard normal
//   paper                  lognormal with 95 % between 0.1 and 1 s, clamped to that range ("hundreds of milliseconds
//                          to seconds", paper 2.2)
//   recorded               drawn from solves of this body that were measured once and kept in the cache folder
// A draw depends on seed and position alone: every policy pays the same for the same state.
//
// The state at rest, where a session asks for it as what it is (PlanningOptions::rest_first): known to be in equilibrium,
// no iteration, one factorisation for its stiffness. recorded charges what the solver was measured to take for it; the
// others a fourth of the draw, one of the iterations that a state takes: full Newton to 1e-6 took 3.0 on average from a
// parent 6 mm away, 4.7 from 12 mm, 5.6 from 24 mm and 7.4 from rest (liver phantom, 48 random positions of its box;
// St. Venant-Kirchhoff 6.2 to 10).

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

class CostModel {
 public:
  virtual ~CostModel() = default;
  virtual double seconds(const Vec3& at) const = 0;
  virtual double rest_seconds() const;  // of the state at rest, asked for as such
};

struct RecordedCosts {
  std::vector<double> solves;  // from a neighbour [s]
  double rest = 0;             // of the state at rest [s]
};

// recorded: the measured times, asked for only by that model. InputError on anything unknown.
std::unique_ptr<CostModel> make_cost(const std::string& spec, std::uint64_t seed,
                                     const std::function<RecordedCosts()>& recorded);
// Throws like make_cost, measures nothing.
void check_cost(const std::string& spec);

}  // namespace forefeel
