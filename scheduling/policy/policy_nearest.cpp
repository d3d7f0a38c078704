// The unknown state nearest to the HIP first (Filipovič, Peterlík, Matyska 2009): (h / (h + |x - HIP|))^2.

#include "scheduling/policy/policies.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {
namespace {

class Nearest final : public Policy {
 public:
  std::string_view name() const override { return "nearest"; }
  bool reads_regions() const override { return false; }
  double at_most(double priority) const override { return priority; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    const double h = view.space.options().spacing;
    const double near = h / (h + (candidate.at - view.hip.at).norm());
    return near * near;  // squared, so that far candidates have small ratios in the test for preemption
  }
};

}  // namespace

std::unique_ptr<Policy> make_nearest(FactoryContext&) {
  return std::make_unique<Nearest>();
}

}  // namespace forefeel
