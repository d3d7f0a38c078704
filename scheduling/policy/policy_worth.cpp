// The priority of a state is the error above the JND that it removes where the hand will be, per second of its solve
// (error_need.hpp). Where it removes none, states nearer to the predicted path come first.
//   worth            the estimates of the error as they are
//   worth-shuffled   the placebo: the same estimates, permuted among the places
// The loss of the placebo against the policy measures the value of the estimates. None has been shown yet:
// apps/studies/worth.toml.

#include <algorithm>

#include "scheduling/policy/error_need.hpp"
#include "scheduling/policy/policies.hpp"

namespace forefeel {
namespace {

class WorthPolicy final : public Policy {
 public:
  WorthPolicy(std::string_view name, ErrorNeedOptions options) : name_(name), need_(options) {}
  std::string_view name() const override { return name_; }
  bool reads_regions() const override { return false; }
  bool reads_surprises() const override { return true; }
  void look(const PlannerView& view) override { need_.look(view); }
  void pend(const PlannerView& view) override { need_.pend(view.pending); }
  double at_most(double priority) const override {
    return priority < nothing ? priority : std::max(priority, 2 * nothing);
  }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    double worth = 0;
    prioritise({&candidate, 1}, view, {&worth, 1});
    return worth;
  }
  void prioritise(std::span<const Candidate> candidates, const PlannerView& view,
                  std::span<double> out) const override {
    need_.worth(candidates, out);
    const double h = view.space.options().spacing;
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (out[i] < nothing) out[i] += nothing * h / (h + distance_to_path(candidates[i].at, view));
  }

 private:
  static constexpr double nothing = 1e-9;  // worth below which the distance decides
  std::string_view name_;
  ErrorNeed need_;
};

}  // namespace

std::unique_ptr<Policy> make_worth(FactoryContext&) {
  return std::make_unique<WorthPolicy>("worth", ErrorNeedOptions{});
}

std::unique_ptr<Policy> make_worth_shuffled(FactoryContext& context) {
  return std::make_unique<WorthPolicy>("worth-shuffled",
                                       ErrorNeedOptions{.shuffle = true, .seed = context.seed});
}

}  // namespace forefeel
