// The priority of a state is the need of the places within its reach, weighted by how soon the hand may be at
// each (coverage_need.hpp). So blank, gap and sparse places on the predicted path become safe first. Where
// there is no need, states nearer to the HIP come first.
//   coverage               the path as predicted
//   clairvoyant-greedy     the path as it will be
//   clairvoyant            the same; under the virtual clock the session rehearses all schedules first
//   shuffled               the placebo of coverage: the same labels, permuted among the places
//   clairvoyant-shuffled   the placebo of clairvoyant-greedy
// The loss of a placebo against its policy measures the value of the labels.

#include <algorithm>

#include "scheduling/policy/coverage_need.hpp"
#include "scheduling/policy/policies.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {
namespace {

class CoveragePolicy final : public Policy {
 public:
  enum class Path { predicted, true_one };
  CoveragePolicy(std::string_view name, Path path, NeedOptions options)
      : name_(name), path_(path), need_(options) {}
  std::string_view name() const override { return name_; }
  bool reads_regions() const override { return false; }
  bool reads_surprises() const override { return true; }
  bool reads_future() const override { return path_ == Path::true_one; }
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
  Path path_;
  CoverageNeed need_;
};

using Path = CoveragePolicy::Path;

}  // namespace

std::unique_ptr<Policy> make_coverage(FactoryContext&) {
  return std::make_unique<CoveragePolicy>("coverage", Path::predicted, NeedOptions{});
}

std::unique_ptr<Policy> make_clairvoyant(FactoryContext&) {
  return std::make_unique<CoveragePolicy>("clairvoyant", Path::true_one, NeedOptions{.path_share = 0.95});
}

std::unique_ptr<Policy> make_shuffled(FactoryContext& context) {
  return std::make_unique<CoveragePolicy>("shuffled", Path::predicted,
                                          NeedOptions{.shuffle = true, .seed = context.seed});
}

std::unique_ptr<Policy> make_clairvoyant_shuffled(FactoryContext& context) {
  return std::make_unique<CoveragePolicy>(
      "clairvoyant-shuffled", Path::true_one,
      NeedOptions{.path_share = 0.95, .shuffle = true, .seed = context.seed});
}

}  // namespace forefeel
