#include "scheduling/render/safety.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scheduling/common/option_check.hpp"

namespace forefeel {

void check(const SafetyOptions& o) {
  using detail::expect_option, detail::positive;
  expect_option(positive(o.force_limit), "force_limit",
                fmt::format("is {}, expected a force above 0 N", o.force_limit));
  expect_option(positive(o.slew_limit), "slew_limit",
                fmt::format("is {}, expected N/s above 0", o.slew_limit));
  expect_option(std::isfinite(o.ramp_seconds) && o.ramp_seconds >= 0, "ramp_seconds",
                fmt::format("is {}, expected 0 s or more", o.ramp_seconds));
  expect_option(positive(o.stale_seconds), "stale_seconds",
                fmt::format("is {}, expected a time above 0 s", o.stale_seconds));
  if (o.coupling)
    expect_option(positive(*o.coupling), "limits.coupling",
                  fmt::format("is {}, expected a stiffness above 0 N/m", *o.coupling));
}

Vec3 Safety::apply(const Vec3& rendered, const Vec3& x, const SafetyMoment& now) noexcept {
  const double dt = std::clamp(now.passed, 0.0, frame_);
  Vec3 force = rendered;
  if (!force.allFinite()) {
    force.setZero();
    ++counts_.non_finite;
  }
  const bool stale = now.age > options_.stale_seconds;
  if (stale) ++counts_.stale;
  gain_ = std::clamp(gain_ + (stale ? -1 : 1) * dt / 0.2, 0.0, 1.0);
  force *= gain_;
  if (now.t < options_.ramp_seconds) force *= std::max(now.t, 0.0) / options_.ramp_seconds;

  if (now.control) force = now.control->shape(force, x);
  const double size = force.norm();
  if (size > options_.force_limit) {
    force *= options_.force_limit / size;
    ++counts_.clamped;
  }
  const double most = options_.slew_limit * dt;
  if (now.ending) {
    const double left = last_.norm();
    force = left > most ? Vec3((1 - most / left) * last_) : Vec3::Zero();
    ++counts_.ending;
  } else {
    force = limited(force, most);
    if (now.control)
      force = now.control->settle(force, x, {.before = last_, .step = most, .size = options_.force_limit});
  }
  if (now.control && now.ending) now.control->account(force, x, last_);
  observe_energy(force, x);
  last_ = force;
  return force;
}

Vec3 Safety::limited(const Vec3& force, double most) noexcept {
  const Vec3 step = force - last_;
  const double wanted = step.norm();
  if (wanted <= most) return force;
  ++counts_.slewed;
  return last_ + most / wanted * step;
}

std::size_t Safety::frames_to_zero() const noexcept {
  return static_cast<std::size_t>(std::min(1e9, std::ceil(last_.norm() / (options_.slew_limit * frame_))));
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
