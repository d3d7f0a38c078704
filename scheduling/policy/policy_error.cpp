// The priority of a state is the chance of an error above the JND that it removes where the hand will be, per second of
// its solve (error_need.hpp). Where it removes none, states nearer to the predicted path come first.
//   error            the estimates of the error as they are
//   error-shuffled   the placebo: the same estimates, permuted among the places
// The loss of the placebo against the policy measures the value of the estimates: 3 and 6 percentage points of first
// visits at load 3 on two bodies, neither significant. Coverage is as good (apps/studies/error.toml). Better estimates
// would gain little. On 6 other motions, at load 3 on the one-node body of that study, a policy that refits the model
// with each candidate and compares it with the true force had 70.4 % of first visits within the JND, coverage 69.5 %.
// With the motion known these were 84.3 and 82.9 %. What limits all policies is the prediction of the hand: a solve
// takes one to two seconds at that load, and in that time the hand crosses the box.
// A rule without estimates, min(delta / h, 4)^3 times the chance of a visit, was 8.2 points [1.5, 14.9] worse: 64.8 %
// of first visits, this policy 73.0 %, coverage 73.1 % (that study's bodies, motions and loads, 3 seeds).

#include "scheduling/policy/error_need.hpp"
#include "scheduling/policy/need_policy.hpp"
#include "scheduling/policy/policies.hpp"

namespace forefeel {
namespace {

using ErrorPolicy = NeedPolicy<ErrorNeed>;

}  // namespace

std::unique_ptr<Policy> make_error(FactoryContext&) {
  return std::make_unique<ErrorPolicy>("error", NeedPath::predicted, ErrorNeedOptions{});
}

std::unique_ptr<Policy> make_error_shuffled(FactoryContext& context) {
  return std::make_unique<ErrorPolicy>("error-shuffled", NeedPath::predicted,
                                       ErrorNeedOptions{.shuffle = true, .seed = context.seed});
}

}  // namespace forefeel
