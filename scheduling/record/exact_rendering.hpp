#pragma once
// What the damped switch alone takes away: an upper bound, the session with the exact force at every place
// from the first moment t0 at which anything can have been solved.
//   F = g before t0,   F = f + e from then on,   e = g(x) - f(x) in the first frame, shrinking by the rule `smooth`
// with f the exact force [N] and g the first guess at it, or zero. t0 is the least time [s] that any solve
// can take, two messages included: of the state at rest, where sessions begin with it, or at a lattice point.
// No policy, predictor, placement, number of workers or model changes what is lost here. A wrong model may be
// faster or slower: one softer than the body leaves less to fade in at first.

#include <functional>
#include <span>

#include "approx/switch/force_switch.hpp"
#include "geometry/coverage/state_space.hpp"
#include "scheduling/workers/cost.hpp"

namespace forefeel {

struct ExactRendering {
  double known = 0;    // the frame's time in which f is known [s]
  double settled = 0;  // from when on F = f [s]; infinite: not in this motion
  std::size_t visits = 0,
              within = 0;  // first visits with a reference; of them |F - f| <= max(tolerance |f|, F_abs)
  double share() const { return visits > 0 ? static_cast<double>(within) / static_cast<double>(visits) : 0; }
};

// motion: the HIP in each frame [m]; first_visits: indices into it, growing. exact(x) gives f; it is called
// for first visits, and for all frames from t0 until e is gone. Where it is not finite e stays as it is.
// guess gives g; empty: zero.
ExactRendering render_exact(std::span<const Vec3> motion, std::span<const std::size_t> first_visits,
                            double t0, const SwitchOptions& switching, double tolerance,
                            const std::function<Vec3(const Vec3&)>& exact,
                            const std::function<Vec3(const Vec3&)>& guess = {});

// t0 [s], every solve begun at once.
double first_possible(const CostModel& cost, const StateSpaceOptions& space, double latency, bool rest_first);

}  // namespace forefeel
