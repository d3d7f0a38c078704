// A policy for the command itself, to copy. It is linked with the command into `forefeel_example`.
// Sessions and studies know it as "ahead". What lies ahead of the hand, within 60 degrees, comes first.

#include "scheduling/policy/policy.hpp"

namespace {

using namespace forefeel;

class Ahead final : public Policy {
 public:
  std::string_view name() const override { return "ahead"; }
  bool reads_regions() const override { return false; }  // Candidate::region is not asked for
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    const double h = view.space.options().spacing;
    const Vec3 way = candidate.at - view.hip.at;
    const bool ahead = way.dot(view.hip.velocity) > 0.5 * way.norm() * view.hip.velocity.norm();
    return (ahead ? 1.0 : 0.1) * h / (h + way.norm());  // finite, not negative, larger is sooner
  }
};

const bool known =
    (register_policy("ahead", [](FactoryContext&) { return std::make_unique<Ahead>(); }), true);

}  // namespace
