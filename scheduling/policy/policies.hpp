#pragma once
// The built-in policies (built_in_policies.cpp, deadline_policies.cpp, utility_need.cpp). clairvoyant and the shuffled
// policies are variants of coverage and error.

#include <memory>

#include "scheduling/common/factory_context.hpp"

namespace forefeel {

class Policy;

std::unique_ptr<Policy> make_fifo(FactoryContext& context);
std::unique_ptr<Policy> make_nearest(FactoryContext& context);
std::unique_ptr<Policy> make_direction(FactoryContext& context);
std::unique_ptr<Policy> make_coverage(FactoryContext& context);
std::unique_ptr<Policy> make_coverage_regions(FactoryContext& context);
std::unique_ptr<Policy> make_clairvoyant(FactoryContext& context);
std::unique_ptr<Policy> make_coarse_to_fine(FactoryContext& context);
std::unique_ptr<Policy> make_error(FactoryContext& context);
std::unique_ptr<Policy> make_utility(FactoryContext& context);
std::unique_ptr<Policy> make_deadline(FactoryContext& context);
std::unique_ptr<Policy> make_slack(FactoryContext& context);
std::unique_ptr<Policy> make_random(FactoryContext& context);
std::unique_ptr<Policy> make_shuffled(FactoryContext& context);
std::unique_ptr<Policy> make_clairvoyant_shuffled(FactoryContext& context);
std::unique_ptr<Policy> make_error_shuffled(FactoryContext& context);

}  // namespace forefeel
