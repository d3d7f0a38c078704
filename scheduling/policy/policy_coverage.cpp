// Regions drive it: a state is worth what the labels of the places it reaches lack, weighted by how soon the hand may
// be there (coverage_need.hpp), so that what is blank, gap or sparse on the predicted path turns safe soonest. Where
// nothing is lacking any more: outward from the HIP.
//   coverage      the path as predicted
//   clairvoyant-greedy   the path as it will be; clairvoyant under the virtual clock rehearses besides (session.cpp)
//   shuffled      the placebo: the same labels, permuted among the places; what it loses is what labels are worth
//   clairvoyant-shuffled   the placebo of clairvoyant-greedy: what labels are worth where the motion is no guess

#include <algorithm>

#include "scheduling/policy/coverage_need.hpp"
#include "scheduling/policy/policies.hpp"

namespace forefeel {
namespace {

class CoveragePolicy final : public Policy {
 public:
  CoveragePolicy(std::string_view name, NeedOptions options) : name_(name), need_(options) {}
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
  CoverageNeed need_;
};

}  // namespace

std::unique_ptr<Policy> make_coverage(const PolicyOptions&) {
  return std::make_unique<CoveragePolicy>("coverage", NeedOptions{});
}

std::unique_ptr<Policy> make_clairvoyant(const PolicyOptions&) {
  return std::make_unique<CoveragePolicy>("clairvoyant", NeedOptions{.path_share = 0.95});
}

std::unique_ptr<Policy> make_shuffled(const PolicyOptions& options) {
  return std::make_unique<CoveragePolicy>("shuffled", NeedOptions{.shuffle = true, .seed = options.seed});
}

std::unique_ptr<Policy> make_clairvoyant_shuffled(const PolicyOptions& options) {
  return std::make_unique<CoveragePolicy>(
      "clairvoyant-shuffled", NeedOptions{.path_share = 0.95, .shuffle = true, .seed = options.seed});
}

}  // namespace forefeel
