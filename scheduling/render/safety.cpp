#include "scheduling/render/safety.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {

Vec3 Safety::apply(const Vec3& rendered, const Vec3& x, double t, double age) noexcept {
  Vec3 force = rendered;
  if (!force.allFinite()) {
    force.setZero();
    ++counts_.non_finite;
  }
  const bool stale = age > options_.stale_seconds;
  if (stale) ++counts_.stale;
  gain_ = std::clamp(gain_ + (stale ? -1 : 1) * options_.frame / 0.2, 0.0, 1.0);
  force *= gain_;
  if (t < options_.ramp_seconds) force *= std::max(t, 0.0) / options_.ramp_seconds;

  const double size = force.norm();
  if (size > options_.force_limit) {
    force *= options_.force_limit / size;
    ++counts_.clamped;
  }
  const Vec3 step = force - last_;
  const double most = options_.slew_limit * options_.frame, wanted = step.norm();
  if (wanted > most) {
    force = last_ + most / wanted * step;
    ++counts_.slewed;
  }
  observe_energy(force, x);
  last_ = force;
  return force;
}

void Safety::observe_energy(const Vec3& force, const Vec3& x) noexcept {
  if (started_) {
    const double put_in = -0.5 * (force + last_).dot(x - last_x_);
    stored_ += put_in;
    work_ += std::abs(put_in);
    generated_ = std::max(generated_, -stored_);
  }
  started_ = true;
  last_x_ = x;
}

}  // namespace forefeel
