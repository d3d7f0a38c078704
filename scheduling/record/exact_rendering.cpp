#include "scheduling/record/exact_rendering.hpp"

#include <algorithm>
#include <limits>

#include "scheduling/render/render_loop.hpp"

namespace forefeel {

ExactRendering render_exact(std::span<const Vec3> motion, std::span<const std::size_t> first_visits,
                            double t0, const SwitchOptions& switching, double tolerance,
                            const std::function<Vec3(const Vec3&)>& exact,
                            const std::function<Vec3(const Vec3&)>& guess) {
  constexpr double never = std::numeric_limits<double>::infinity();
  ExactRendering result{.known = never, .settled = never};
  SwitchOptions smooth = switching;
  smooth.rule = SwitchRule::smooth;
  ForceSwitch damped(smooth);
  auto visit = first_visits.begin();
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const double t = frame_time(k, switching.frame);
    const bool known = t >= t0, fading = known && result.settled == never;
    const bool visited = visit != first_visits.end() && *visit == k;
    visit += visited ? 1 : 0;
    if (!fading && !visited) continue;
    const Vec3 force = exact(motion[k]);
    if (!force.allFinite()) continue;
    const Vec3 before = !known || fading ? (guess ? guess(motion[k]) : Vec3::Zero()) : force;
    Vec3 rendered = known ? force : before;
    if (fading) {
      const bool comes = result.known == never;
      if (comes) result.known = t;
      rendered = damped.step(comes ? before : force, force, comes).force;
      if (rendered == force) result.settled = t;
    }
    if (!visited) continue;
    ++result.visits;
    result.within +=
        (rendered - force).norm() <= std::max(tolerance * force.norm(), switching.jnd_floor) ? 1 : 0;
  }
  return result;
}

double first_possible(const CostModel& cost, const StateSpaceOptions& space, double latency,
                      bool rest_first) {
  double least = rest_first ? checked_rest_seconds(cost) : std::numeric_limits<double>::infinity();
  for (const Vec3& x : lattice(space.box, space.spacing)) least = std::min(least, checked_seconds(cost, x));
  return least + 2 * latency;
}

}  // namespace forefeel
