#pragma once
// What error does the model have where nothing was solved? With f~ the model as the HIP would feel it and g,
// h two interpolants of the stored energy from the same states (placement_energy.hpp: |y|^9 with quartic,
// |y|^7 with cubic p),
//   estimate(x) = 1.1 (|f~ - g| + 1/2 |g - h|) / max(|f~|, f0)                                        [1]
// g is nearer to the truth than f~, so |f~ - g| is close to the error itself; |g - h| covers for g where the
// states are still too few for it. The factor was set on a liver whose truth is known: there 95 % quantiles
// of the true error are 0.6 to 1.1 times those of the estimate, from 8 states on. Infinite where the states
// do not determine g (fewer than 4, or without stiffness). Allocates: made for the planner, not for the
// render loop.

#include <array>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "approx/select/updater.hpp"
#include "scheduling/placement/placement_energy.hpp"

namespace forefeel {

struct EstimateOptions {
  ModelOptions model = {.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 25};
  double floor = 0.05;            // f0 [N]
  std::size_t interpolated = 32;  // most states of g and h: all, or those around x
};

class ErrorEstimator {
 public:
  // The space must outlive the estimator and may grow meanwhile; both belong to one thread.
  ErrorEstimator(const StateSpace& space, EstimateOptions options);
  double operator()(const Vec3& x);  // [1]; infinite where nothing can be said
  // The model's force at x, as `operator()` sees it [N].
  Vec3 force(const Vec3& x);

 private:
  struct Pair {
    std::shared_ptr<const EnergyInterpolant> fine, coarse;
  };
  const Pair& interpolants(const Vec3& x);

  const StateSpace& space_;
  EstimateOptions options_;
  std::array<bool, 3> flat_{};
  ModelUpdater updater_;
  Model model_;
  std::vector<StateId> ids_;
  std::size_t seen_ = 0;  // states known at the last call
  std::map<std::vector<StateId>, Pair> fits_;
};

}  // namespace forefeel
