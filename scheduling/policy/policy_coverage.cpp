// The priority of a state is the need of the places within its reach, weighted by how soon the hand may be at
// each (coverage_need.hpp). So blank, gap and sparse places on the predicted path become safe first. Where
// there is no need, states nearer to the HIP come first.
//   coverage               the path as predicted
//   clairvoyant-greedy     the path as it will be
//   clairvoyant            the same; under the virtual clock the session rehearses all schedules first
//   shuffled               the placebo of coverage: the same labels, permuted among the places
//   clairvoyant-shuffled   the placebo of clairvoyant-greedy
// The loss of a placebo against its policy measures the value of the labels.

#include "scheduling/policy/coverage_need.hpp"
#include "scheduling/policy/need_policy.hpp"
#include "scheduling/policy/policies.hpp"

namespace forefeel {
namespace {

using CoveragePolicy = NeedPolicy<CoverageNeed>;
using Path = NeedPath;

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
