// Expected error times the chance that the state is needed:
//   min(delta / h, 4)^3 max_j exp(-d_j^2 / (2 (s_j^2 + h^2))) T / (T + horizon_j)
// The error of a kernel of order 3 grows with the cube of delta, the distance to the nearest state that is
// known or being solved. The chance is that of the HIP being within a spacing h of the candidate at the j-th
// prediction: a normal density of deviation s_j, at distance d_j from the predicted position, discounted by
// the horizon; T is the time of a solve.

#include <algorithm>
#include <cmath>

#include "scheduling/policy/policies.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {
namespace {

class ErrorPolicy final : public Policy {
 public:
  std::string_view name() const override { return "error"; }
  bool reads_regions() const override { return false; }
  double at_most(double priority) const override { return priority; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    const double h = view.space.options().spacing, solve = std::max(view.solve_seconds, 1e-3);
    double chance = 0;
    for (const Prediction& p : view.predicted) {
      const double variance = p.deviation * p.deviation + h * h;
      const double near = std::exp(-(candidate.at - p.at).squaredNorm() / (2 * variance));
      chance = std::max(chance, near * solve / (solve + p.horizon));
    }
    double delta = candidate.delta;  // states that are being solved count as known
    for (const Vec3& p : view.pending) delta = std::min(delta, (candidate.at - p).norm());
    const double reach = std::min(delta / h, 4.0);
    const double far =
        1e-6 * h / (h + (candidate.at - view.hip.at).norm());  // orders candidates that no prediction reaches
    return reach * reach * reach * chance + far;
  }
};

}  // namespace

std::unique_ptr<Policy> make_error(FactoryContext&) {
  return std::make_unique<ErrorPolicy>();
}

}  // namespace forefeel
