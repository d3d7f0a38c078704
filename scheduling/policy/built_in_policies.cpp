#include <algorithm>
#include <cmath>
#include <limits>

#include "scheduling/policy/coverage_need.hpp"
#include "scheduling/policy/error_need.hpp"
#include "scheduling/policy/need_policy.hpp"
#include "scheduling/policy/policies.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {

// The unknown state nearest to the HIP first (Filipovič, Peterlík, Matyska 2009): (h / (h + |x - HIP|))^2.

namespace {

class Nearest final : public Policy {
 public:
  std::string_view name() const override { return "nearest"; }
  bool reads_regions() const override { return false; }
  double at_most(double priority) const override { return priority; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    const double h = view.space.options().spacing;
    const double near = h / (h + (candidate.at - view.hip.at).norm());
    return near * near;  // squared, so that far candidates have small ratios in the test for preemption
  }
};

}  // namespace

std::unique_ptr<Policy> make_nearest(FactoryContext&) {
  return std::make_unique<Nearest>();
}

// First come, first served: candidates in the order in which the HIP came near them, priority 1 / (1 + time).
// Those that it never came near follow, by distance from rest.

namespace {

class Fifo final : public Policy {
 public:
  std::string_view name() const override { return "fifo"; }
  bool reads_regions() const override { return false; }
  double at_most(double priority) const override { return priority; }
  double priority(const Candidate& candidate, const PlannerView&) const override {
    const double outward = 1e-6 / (1.0 + candidate.order);
    return std::isfinite(candidate.requested) ? 1 / (1 + std::abs(candidate.requested)) + outward : outward;
  }
};

}  // namespace

std::unique_ptr<Policy> make_fifo(FactoryContext&) {
  return std::make_unique<Fifo>();
}

// States along the predicted motion, the soonest first. A state requested now is known after T, the time of a
// solve. States that are then still ahead of the hand have the priority
//   1/2 + T / (T + t) / 2,    t = min_{s >= T} s - T + 2 d(s) / v
// with d(s) the distance from the position predicted in s seconds, and v the speed of the hand. All others,
// which the hand passes earlier or never approaches to a lattice cell, come after them with T / (T + t) / 2.

namespace {

class Direction final : public Policy {
 public:
  std::string_view name() const override { return "direction"; }
  bool reads_regions() const override { return false; }
  double at_most(double priority) const override { return priority; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    const double solve = std::max(view.solve_seconds, 1e-3);
    const Pass pass = passing(candidate.at, view, solve);
    const double share = 0.5 * solve / (solve + pass.wait);
    return pass.in_time ? 0.5 + share : share;
  }

 private:
  struct Pass {
    double wait;   // t [s]
    bool in_time;  // the path is nearest after T, and that near is a cell's diagonal or less
  };
  static Pass passing(const Vec3& at, const PlannerView& view, double solve) {
    constexpr double slowest = 0.01;  // [m/s]: a hand that holds still may move on
    const double speed =
        0.5 * std::max(view.hip.velocity.allFinite() ? view.hip.velocity.norm() : 0.0, slowest);
    const double cell = 1.74 * view.space.options().spacing;  // its diagonal
    const auto path = view.predicted;
    double wait = std::numeric_limits<double>::infinity(), nearest = wait, when = 0;
    const auto see = [&](double horizon, const Vec3& place) {
      const double distance = (at - place).norm();
      if (distance < nearest) {
        nearest = distance;
        when = horizon;
      }
      if (horizon >= solve) wait = std::min(wait, horizon - solve + distance / speed);
    };
    constexpr int parts = 4;  // of each stretch between two predictions
    for (std::size_t i = 0; i < path.size(); ++i) {
      see(path[i].horizon, path[i].at);
      for (int k = 1; i + 1 < path.size() && k < parts; ++k) {
        const double w = static_cast<double>(k) / parts;
        see((1 - w) * path[i].horizon + w * path[i + 1].horizon, (1 - w) * path[i].at + w * path[i + 1].at);
      }
    }
    if (!(wait < std::numeric_limits<double>::infinity()))
      wait = (at - view.hip.at).norm() / speed;  // the path ends before T
    return {wait, when >= solve && nearest <= cell};
  }
};

}  // namespace

std::unique_ptr<Policy> make_direction(FactoryContext&) {
  return std::make_unique<Direction>();
}

// Coarse lattice points far around the predicted path, fine ones near it. With d the distance to the path the
// priority is
//   s / (s + d),    s = 4 h for lattice points at multiples of 4 h, 2 h at multiples of 2 h, h elsewhere

namespace {

double level_spacing(const Vec3& at, double h) {
  long all = 0;
  for (int i = 0; i < 3; ++i) all |= std::lround(at[i] / h);
  if ((all & 3) == 0) return 4 * h;
  return (all & 1) == 0 ? 2 * h : h;
}

class CoarseToFine final : public Policy {
 public:
  std::string_view name() const override { return "coarse-to-fine"; }
  bool reads_regions() const override { return false; }
  double at_most(double priority) const override { return priority; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    const double s = level_spacing(candidate.at, view.space.options().spacing);
    return s / (s + distance_to_path(candidate.at, view));
  }
};

}  // namespace

std::unique_ptr<Policy> make_coarse_to_fine(FactoryContext&) {
  return std::make_unique<CoarseToFine>();
}

// The priority of a state is the need of the places within its reach, weighted by how soon the hand may be at
// each (coverage_need.hpp). So blank, gap and sparse places on the predicted path become safe first. Where
// there is no need, states nearer to the HIP come first.
//   coverage               the path as predicted
//   coverage-regions       the same with the volumes of regions in place of labels at points
//   clairvoyant-greedy     the path as it will be
//   clairvoyant            the same; under the virtual clock the session rehearses all schedules first
//   shuffled               the placebo of coverage: the same labels, permuted among the places
//   clairvoyant-shuffled   the placebo of clairvoyant-greedy
// The loss of a placebo against its policy measures the value of the labels.

namespace {

using CoveragePolicy = NeedPolicy<CoverageNeed>;
using Path = NeedPath;

}  // namespace

std::unique_ptr<Policy> make_coverage(FactoryContext&) {
  return std::make_unique<CoveragePolicy>("coverage", Path::predicted, NeedOptions{});
}

std::unique_ptr<Policy> make_coverage_regions(FactoryContext&) {
  return std::make_unique<CoveragePolicy>("coverage-regions", Path::predicted, NeedOptions{.regions = true});
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
