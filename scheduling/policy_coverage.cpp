// Regions drive it: a state is worth what its region lacks, w(label), over the time until the HIP is there,
//   w(label) T / (T + time to reach),   T the time of a solve,
// so that what is blank, gap or sparse on the predicted path turns safe soonest. w falls from blank to safe: the
// error does. Measures on the way: a state near a known one adds little, so w also grows with delta / h.

#include <algorithm>

#include "scheduling/policies.hpp"

namespace forefeel {
namespace {

class CoveragePolicy final : public Policy {
 public:
  std::string_view name() const override { return "coverage"; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    const double solve = std::max(view.solve_seconds, 1e-3), h = view.space.options().spacing;
    const double soon = solve / (solve + time_to_reach(candidate.at, view));
    const double gain = 0.5 + 0.5 * std::min(candidate.delta / h, 3.0);
    return weight(candidate.region) * gain * soon;
  }

 private:
  static double weight(Label label) {
    switch (label) {
      case Label::blank: return 1.0;
      case Label::gap: return 0.8;
      case Label::sparse: return 0.6;
      case Label::safe: return 0.05;
    }
    return 1.0;
  }
};

}  // namespace

std::unique_ptr<Policy> make_coverage(const PolicyOptions&) { return std::make_unique<CoveragePolicy>(); }

}  // namespace forefeel
