#pragma once
// The messages between planner and loop about error bars. For the rendered force F [N] of a frame at x, with f~ the
// force of the newest model there, the half-width of the bar of level p is
//   e_p = sqrt((q_p s(x))^2 + r^2),   r = ||F - f~||     [N]
// s [N]: scale of the model's error (approx/error/error_scale.hpp), q_p [1]: factor of the level
// (conformal_factors.hpp), r [N]: difference between rendered and model force that the switch has not yet removed. r is
// known exactly; its direction is assumed independent of the model's error. When the true force f of a frame becomes
// known, the score of the frame is
//   sqrt(max(0, ||F - f||^2 - r^2)) / s
// The score is at most q_p if and only if the bar contains f.

#include <algorithm>
#include <cmath>
#include <limits>

#include "approx/error/conformal_factors.hpp"
#include "approx/error/error_scale.hpp"

namespace forefeel {

// From the planner to the loop, copied as a whole. Infinite bars while no model has states.
struct BarEstimate {
  ErrorScale scale = {};
  ConformalFactors::Factors factors = ConformalFactors::unknown_factors();
  Label label = Label::blank;  // at the HIP when the estimate was made; the factors are those of this label
};

// From the loop to the planner: the force rendered at a position, to be scored once the true force is known.
struct RenderedFrame {
  Vec3 at = Vec3::Zero(), force = Vec3::Zero();  // of the HIP [m]; F [N]
  double scale = 0, residual = 0;                // s, r [N]
  Label label = Label::blank;

  double score(const Vec3& truth) const noexcept {
    return std::sqrt(std::max(0.0, (force - truth).squaredNorm() - residual * residual)) / scale;
  }
};

}  // namespace forefeel
