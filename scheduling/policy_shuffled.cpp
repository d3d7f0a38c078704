// The placebo: `coverage` with the labels of all candidates permuted at random. What it loses is what labels are
// worth.

#include <utility>

#include "scheduling/policies.hpp"
#include "scheduling/random.hpp"

namespace forefeel {
namespace {

class Shuffled final : public Policy {
 public:
  explicit Shuffled(std::uint64_t seed) : seed_(seed), coverage_(make_coverage({})) {}
  std::string_view name() const override { return "shuffled"; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    return coverage_->priority(candidate, view);
  }
  void prioritise(std::span<const Candidate> candidates, const PlannerView& view, std::span<double> out) const override {
    std::vector<Label> labels;
    for (const Candidate& c : candidates) labels.push_back(c.region);
    const std::uint64_t step = mix(seed_, candidates.size());
    for (std::size_t i = labels.size(); i > 1; --i) std::swap(labels[i - 1], labels[mix(step, i) % i]);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      Candidate changed = candidates[i];
      changed.region = labels[i];
      out[i] = coverage_->priority(changed, view);
    }
  }

 private:
  std::uint64_t seed_;
  std::unique_ptr<Policy> coverage_;
};

}  // namespace

std::unique_ptr<Policy> make_shuffled(const PolicyOptions& options) { return std::make_unique<Shuffled>(options.seed); }

}  // namespace forefeel
