#pragma once
// Estimates the error of the model where nothing was solved. f~: force of the model at x. g, h: forces of two
// interpolants of the stored energy from the same states (placement_energy.hpp: |y|^9 with quartic, |y|^7 with cubic
// p):
//   estimate(x) = 1.1 (|f~ - g| + 1/2 |g - h|) / max(|f~|, f0)                                        [1]
// g is nearer to the truth than f~, so |f~ - g| is close to the error itself. |g - h| accounts for the error
// of g while the states are few. The factor 1.1 was fitted on a liver whose true error is known: from 8
// states on, the 95 % quantiles of the true error are 0.6 to 1.1 times those of the estimate. The estimate is
// infinite if the states do not determine g (fewer than 4, or without stiffness). It allocates: use it in the
// planner, not in the render loop.

#include <array>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "approx/model/updater.hpp"
#include "scheduling/placement/placement_energy.hpp"

namespace forefeel {

struct EstimateOptions {
  ModelOptions model = {.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 25};
  double floor = 0.05;            // f0 [N]
  std::size_t interpolated = 32;  // most states of g and h; if there are more, those around x
};

class ErrorEstimator {
 public:
  // The space must outlive the estimator and may grow in between; both belong to one thread.
  ErrorEstimator(const StateSpace& space, EstimateOptions options);
  double operator()(const Vec3& x);  // [1]; infinite if there is no estimate
  // The model's force at x, as used by operator() [N].
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
