// States along the predicted motion, the soonest first. A state requested now is known after T, the time of a
// solve. States that are then still ahead of the hand have the priority
//   1/2 + T / (T + t) / 2,    t = min_{s >= T} s - T + 2 d(s) / v
// with d(s) the distance from the position predicted in s seconds, and v the speed of the hand. All others,
// which the hand passes earlier or never approaches to a lattice cell, come after them with T / (T + t) / 2.

#include <algorithm>
#include <limits>

#include "scheduling/policy/policies.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {
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

}  // namespace forefeel
