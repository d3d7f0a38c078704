#include "scheduling/policy/policy.hpp"

#include <algorithm>
#include <limits>

#include "scheduling/common/registry.hpp"
#include "scheduling/policy/policies.hpp"

namespace forefeel {
namespace {

Registry<PolicyFactory>& policies() {
  static Registry<PolicyFactory> policies(
      "policy",
      {{"coverage", make_coverage, "places that the hand may reach soon and that are blank, gap or sparse"},
       {"coverage-regions", make_coverage_regions,
        "coverage with volumes of regions in place of labels at points"},
       {"fifo", make_fifo, "first come, first served: in the order in which the hand came near"},
       {"nearest", make_nearest, "the unknown state nearest to the tip"},
       {"direction", make_direction, "states along the predicted motion, the soonest first"},
       {"coarse-to-fine", make_coarse_to_fine,
        "coarse lattice points far around the predicted path, fine ones near it"},
       {"error", make_error,
        "chance of an error above the JND on the path ahead that a solve removes per second"},
       {"utility", make_utility,
        "largest gain in expected error per solve, over the predicted distribution of places"},
       {"deadline", make_deadline, "the place first that the predicted hand enters first"},
       {"slack", make_slack,
        "least time to spare until the hand enters the place; what would come too late last"},
       {"random", make_random, "placebo of all: a random order of all places"},
       {"clairvoyant", make_clairvoyant,
        "upper bound: knows the motion, simulates every policy, runs the best"},
       {"clairvoyant-greedy", make_clairvoyant, "coverage with the motion known"},
       {"shuffled", make_shuffled, "placebo of coverage: its labels, permuted among the places"},
       {"clairvoyant-shuffled", make_clairvoyant_shuffled, "placebo of clairvoyant-greedy"},
       {"error-shuffled", make_error_shuffled,
        "placebo of error: its estimates, permuted among the places"}});
  return policies;
}

// The point of the segment a b nearest to q, as its share of the way from a to b.
double share_along(const Vec3& a, const Vec3& b, const Vec3& q) {
  const Vec3 step = b - a;
  const double length2 = step.squaredNorm();
  return length2 > 0 ? std::clamp((q - a).dot(step) / length2, 0.0, 1.0) : 0.0;
}

}  // namespace

double Policy::at_most(double) const {
  return std::numeric_limits<double>::infinity();
}

void Policy::prioritise(std::span<const Candidate> candidates, const PlannerView& view,
                        std::span<double> out) const {
  for (std::size_t i = 0; i < candidates.size(); ++i) out[i] = priority(candidates[i], view);
}

void register_policy(const std::string& name, PolicyFactory factory) {
  policies().add(name, std::move(factory));
}

std::vector<std::string> policy_names() {
  return policies().names();
}

bool is_placebo(std::string_view policy) {
  return policy == "random" || policy == "shuffled" || policy.ends_with("-shuffled");
}

std::vector<Declared> declared_policies() {
  return policies().declared();
}

std::unique_ptr<Policy> make_policy(const PolicySpec& policy, const FactoryContext& context) {
  return make_registered(policies().at(policy.name), "policy", policy, context);
}

double time_to_reach(const Vec3& at, const PlannerView& view) {
  constexpr double slowest = 0.01;  // [m/s]: a hand that holds still may move on
  // Off the path the hand has to turn first and is half as fast.
  const double speed =
      0.5 * std::max(view.hip.velocity.allFinite() ? view.hip.velocity.norm() : 0.0, slowest);
  const auto path = view.predicted;
  if (path.empty()) return (at - view.hip.at).norm() / speed;
  double best = path[0].horizon + (at - path[0].at).norm() / speed;
  for (std::size_t i = 1; i < path.size() && path[i - 1].horizon < best; ++i) {  // horizons grow
    const double w = share_along(path[i - 1].at, path[i].at, at);
    const double along = (1 - w) * path[i - 1].horizon + w * path[i].horizon, left = (best - along) * speed;
    const double distance2 = (at - (1 - w) * path[i - 1].at - w * path[i].at).squaredNorm();
    if (left > 0 && distance2 < left * left) best = along + std::sqrt(distance2) / speed;
  }
  return best;
}

double distance_to_path(const Vec3& at, const PlannerView& view) {
  const auto path = view.predicted;
  double best = path.empty() ? (at - view.hip.at).norm() : (at - path[0].at).norm();
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double w = share_along(path[i - 1].at, path[i].at, at);
    best = std::min(best, (at - (1 - w) * path[i - 1].at - w * path[i].at).norm());
  }
  return best;
}

}  // namespace forefeel
