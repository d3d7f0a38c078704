#pragma once
// The messages between planner and loop about error bars. For the rendered force F [N] of a frame at x, with f~ the
// force of the newest model there, the half-width of the bar of level p is
//   e_p = max(sqrt((q_p s(x))^2 + r^2), 0.1 max(share ||F||, F_abs)),   r = ||F - f~||     [N]
// The floor is a tenth of the just noticeable difference (switch_options.hpp): nobody needs a finer bar.
// s [N]: scale of the model's error (approx/error/error_scale.hpp), q_p [1]: factor of the level
// (error_bar.hpp), r [N]: difference between rendered and model force that the switch has not yet removed. r is
// known exactly; its direction is assumed independent of the model's error. When the true force f of a frame becomes
// known, the score of the frame is
//   sqrt(max(0, ||F - f||^2 - r^2)) / s
// Above the floor, the score is at most q_p if and only if the bar contains f.

#include <algorithm>
#include <cmath>
#include <limits>

#include "approx/error/error_bar.hpp"
#include "approx/error/error_scale.hpp"
#include "approx/switch/switch_options.hpp"

namespace forefeel {

// Least half-width of a bar around the rendered force F [N].
inline double bar_floor(const Vec3& force, const SwitchOptions& jnd) noexcept {
  return 0.1 * std::max(jnd.jnd_share * force.norm(), jnd.jnd_floor);
}

// From the planner to the loop, copied as a whole. Infinite bars while no model has states.
struct BarEstimate {
  ErrorScale scale = {};
  BarFactors factors = unknown_factors();
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
