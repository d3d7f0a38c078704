#pragma once
// What a solve costs under the virtual clock [s]:
//   constant:S             always S
//   lognormal:MEDIAN,SIGMA exp(ln MEDIAN + SIGMA n), n standard normal
//   paper                  lognormal with 95 % between 0.1 and 1 s, clamped to that range ("hundreds of milliseconds
//                          to seconds", paper 2.2)
//   recorded               drawn from solves of this body that were measured once and kept in the cache folder
// A draw depends on seed and position alone: every policy pays the same for the same state.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "geometry/types.hpp"

namespace forefeel {

class CostModel {
 public:
  virtual ~CostModel() = default;
  virtual double seconds(const Vec3& at) const = 0;
};

// recorded: the measured solve times, asked for only by that model. InputError on anything unknown.
std::unique_ptr<CostModel> make_cost(const std::string& spec, std::uint64_t seed,
                                     const std::function<std::vector<double>()>& recorded);
// Throws like make_cost, measures nothing.
void check_cost(const std::string& spec);

}  // namespace forefeel
