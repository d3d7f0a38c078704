// Along the predicted motion: what the HIP reaches soonest first, T / (T + time to reach), T the time of a solve.

#include <algorithm>

#include "scheduling/policies.hpp"

namespace forefeel {
namespace {

class Direction final : public Policy {
 public:
  std::string_view name() const override { return "direction"; }
  bool reads_regions() const override { return false; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    const double solve = std::max(view.solve_seconds, 1e-3);
    return solve / (solve + time_to_reach(candidate.at, view));
  }
};

}  // namespace

std::unique_ptr<Policy> make_direction(const PolicyOptions&) { return std::make_unique<Direction>(); }

}  // namespace forefeel
