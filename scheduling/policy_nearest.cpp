// The nearest unknown lattice states around the HIP first (Filipovič, Peterlík, Matyska 2009): h / (h + |x - HIP|).

#include "scheduling/policies.hpp"

namespace forefeel {
namespace {

class Nearest final : public Policy {
 public:
  std::string_view name() const override { return "nearest"; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    const double h = view.space.options().spacing;
    return h / (h + (candidate.at - view.hip.at).norm());
  }
};

}  // namespace

std::unique_ptr<Policy> make_nearest(const PolicyOptions&) { return std::make_unique<Nearest>(); }

}  // namespace forefeel
