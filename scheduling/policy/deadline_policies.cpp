#include <algorithm>
#include <cmath>
#include <limits>

#include "scheduling/motion/random.hpp"
#include "scheduling/policy/policies.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {

// The floor: every place has a random priority that it keeps for the session, so the order is a random permutation.
// Priorities lie in (1/2, 1): a running job is never cancelled.

namespace {

class Random final : public Policy {
 public:
  explicit Random(std::uint64_t seed) : seed_(seed) {}
  std::string_view name() const override { return "random"; }
  bool reads_regions() const override { return false; }
  double at_most(double priority) const override { return priority; }
  double priority(const Candidate& candidate, const PlannerView&) const override {
    return 0.5 + 0.5 * random::uniform(random::mix(seed_, random::position_key(candidate.at)));
  }

 private:
  std::uint64_t seed_;
};

}  // namespace

std::unique_ptr<Policy> make_random(FactoryContext& context) {
  return std::make_unique<Random>(context.seed);
}

// A state at c serves the places within a spacing h of it. Its deadline D [s] is when the predicted hand enters them,
// its slack D - T, with T the expected time of a solve (Liu and Layland 1973; Mok 1983).
//   deadline   the earliest deadline first, although it may be missed: 1/2 + T / (T + D) / 2
//   slack      the least slack first. States that cannot be ready in time follow, the least late first:
//              2/3 + T / (T + D - T) / 3 for D >= T, else 1/3 + D / T / 3
// States without a deadline, whose places the path does not enter, come last, by their distance d from it:
//   h / (h + d) / 4

namespace {

// First time at which the path from a to b, in a unit of time, is within r of q; infinite if it never is.
double entry(const Vec3& a, const Vec3& b, const Vec3& q, double r) {
  constexpr double never = std::numeric_limits<double>::infinity();
  const Vec3 from = a - q, step = b - a;
  const double c = from.squaredNorm() - r * r, half = from.dot(step), length2 = step.squaredNorm();
  if (c <= 0) return 0;
  const double inside = half * half - length2 * c;
  if (!(inside >= 0) || !(half < 0)) return never;
  const double when = c / (std::sqrt(inside) - half);  // the smaller root, without cancellation
  return when <= 1 ? when : never;
}

double deadline_of(const Vec3& at, const PlannerView& view) {
  constexpr double rounding = 1 + 1e-9;
  const double reach = rounding * view.space.options().spacing;
  const auto path = view.predicted;
  constexpr double never = std::numeric_limits<double>::infinity();
  if (path.empty()) return (at - view.hip.at).norm() <= reach ? 0 : never;
  if ((at - path[0].at).norm() <= reach) return path[0].horizon;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double share = entry(path[i - 1].at, path[i].at, at, reach);
    if (share <= 1) return path[i - 1].horizon + share * (path[i].horizon - path[i - 1].horizon);
  }
  return never;
}

class Deadline final : public Policy {
 public:
  explicit Deadline(bool firm) : firm_(firm) {}
  std::string_view name() const override { return firm_ ? "slack" : "deadline"; }
  bool reads_regions() const override { return false; }
  double at_most(double priority) const override { return priority; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    const double h = view.space.options().spacing, solve = std::max(view.solve_seconds, 1e-3);
    const double due = deadline_of(candidate.at, view);
    const double near = h / (h + distance_to_path(candidate.at, view));
    if (!std::isfinite(due)) return near / 4;
    const double tie = 1e-6 * near;  // places that the hand is in have one deadline
    if (!firm_) return 0.5 + 0.5 * solve / (solve + due) + tie;
    return (due >= solve ? 2 + solve / due : 1 + due / solve) / 3 + tie;
  }

 private:
  bool firm_;  // a missed deadline is worth less than one that can be met
};

}  // namespace

std::unique_ptr<Policy> make_deadline(FactoryContext&) {
  return std::make_unique<Deadline>(false);
}

std::unique_ptr<Policy> make_slack(FactoryContext&) {
  return std::make_unique<Deadline>(true);
}

}  // namespace forefeel
