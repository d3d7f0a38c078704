// First come, first served: candidates in the order in which the HIP came near them, priority 1 / (1 + time).
// Those that it never came near follow, by distance from rest.

#include <cmath>

#include "scheduling/policy/policies.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {
namespace {

class Fifo final : public Policy {
 public:
  std::string_view name() const override { return "fifo"; }
  bool reads_regions() const override { return false; }
  double at_most(double priority) const override { return priority; }
  double priority(const Candidate& candidate, const PlannerView&) const override {
    const double outward = 1e-6 / (1.0 + candidate.order);
    return std::isfinite(candidate.requested) ? 1 / (1 + std::abs(candidate.requested)) + outward : outward;
  }
};

}  // namespace

std::unique_ptr<Policy> make_fifo(FactoryContext&) {
  return std::make_unique<Fifo>();
}

}  // namespace forefeel
