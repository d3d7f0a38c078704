#pragma once
// The loss due to the damped switch alone. It gives an upper bound for sessions: the session with the exact force at
// every place from the first moment t0 at which a solve can be finished.
//   F = g before t0,   F = f + e after it,   e = g(x) - f(x) at t0, shrinking by the rule `smooth`
// where f is the exact force [N] and g the first guess, or zero. t0 is the least time [s] of any solve with
// its two messages: of the state at rest if sessions begin with it, else at a lattice point. This loss does
// not depend on policy, predictor, placement, number of workers or model. It bounds exact models only. An inexact
// model can do better: if it is softer than the body, the first step to fade in is smaller.

#include <functional>
#include <span>

#include "approx/switch/force_switch.hpp"
#include "geometry/coverage/state_space.hpp"
#include "scheduling/workers/cost.hpp"

namespace forefeel {

struct ExactRendering {
  double known = 0;    // the frame's time in which f is known [s]
  double settled = 0;  // F = f from this time on [s]; infinite: never in this motion
  std::size_t visits = 0,
              within = 0;  // first visits with a reference; of them |F - f| <= max(tolerance |f|, F_abs)
  double share() const { return visits > 0 ? static_cast<double>(within) / static_cast<double>(visits) : 0; }
};

// motion: the HIP in each frame [m]. first_visits: increasing indices into it. exact(x) returns f; it is
// called for first visits, and for all frames from t0 until e is zero. Where f is not finite, e is unchanged.
// guess returns g; empty: zero.
ExactRendering render_exact(std::span<const Vec3> motion, std::span<const std::size_t> first_visits,
                            double t0, const SwitchOptions& switching, double tolerance,
                            const std::function<Vec3(const Vec3&)>& exact,
                            const std::function<Vec3(const Vec3&)>& guess = {});

// t0 [s], if every solve begins at time 0.
double first_possible(const CostModel& cost, const StateSpaceOptions& space, double latency, bool rest_first);

}  // namespace forefeel
