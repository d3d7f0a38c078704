#pragma once
// The policies that come with the toolkit; one file each, policy_NAME.cpp, to copy for one's own
// (clairvoyant and the shuffled ones are variants of coverage, in its file).

#include "scheduling/policy/policy.hpp"

namespace forefeel {

std::unique_ptr<Policy> make_fifo(const PolicyOptions& options);
std::unique_ptr<Policy> make_nearest(const PolicyOptions& options);
std::unique_ptr<Policy> make_direction(const PolicyOptions& options);
std::unique_ptr<Policy> make_coverage(const PolicyOptions& options);
std::unique_ptr<Policy> make_clairvoyant(const PolicyOptions& options);
std::unique_ptr<Policy> make_coarse_to_fine(const PolicyOptions& options);
std::unique_ptr<Policy> make_error(const PolicyOptions& options);
std::unique_ptr<Policy> make_shuffled(const PolicyOptions& options);
std::unique_ptr<Policy> make_clairvoyant_shuffled(const PolicyOptions& options);

}  // namespace forefeel
