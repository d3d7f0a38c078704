// The priority of a state is the chance of an error above the JND that it removes where the hand will be, per second of
// its solve (error_need.hpp). Where it removes none, states nearer to the predicted path come first.
//   worth            the estimates of the error as they are
//   worth-shuffled   the placebo: the same estimates, permuted among the places
// The loss of the placebo against the policy measures the value of the estimates. None has been shown yet:
// apps/studies/worth.toml.

#include "scheduling/policy/error_need.hpp"
#include "scheduling/policy/need_policy.hpp"
#include "scheduling/policy/policies.hpp"

namespace forefeel {
namespace {

using WorthPolicy = NeedPolicy<ErrorNeed>;

}  // namespace

std::unique_ptr<Policy> make_worth(FactoryContext&) {
  return std::make_unique<WorthPolicy>("worth", NeedPath::predicted, ErrorNeedOptions{});
}

std::unique_ptr<Policy> make_worth_shuffled(FactoryContext& context) {
  return std::make_unique<WorthPolicy>("worth-shuffled", NeedPath::predicted,
                                       ErrorNeedOptions{.shuffle = true, .seed = context.seed});
}

}  // namespace forefeel
