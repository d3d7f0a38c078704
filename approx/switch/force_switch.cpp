#include "approx/switch/force_switch.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {

std::string_view name(SwitchRule rule) {
  return rule == SwitchRule::paper ? "paper" : rule == SwitchRule::smooth ? "smooth" : "none";
}

namespace {

// A step with |dF| <= max(floor, share |F|), rounding included, for |F| taken before as well as after the
// step: |F| after it is at least |F| before it / (1 + share).
double allowed(double floor, double share, double before) {
  return std::max(floor, share / (1 + share) * before) * (1 - 1e-9);
}

// The longest s for which s <= max(floor, share |F|) holds with F = before and with F = before - s u, u a
// unit vector:
// share |before| if |F| grows with the step, else the root of s = share |before - s u|.
double longest_step(double floor, double share, const Vec3& before, const Vec3& u) {
  const double size = before.norm(), along = share * before.dot(u), rest = 1 - share * share;
  const double shrinking = share * (std::sqrt(along * along + rest * size * size) - along) / rest;
  return std::max(floor, std::min(share * size, shrinking)) * (1 - 1e-9);
}

double bound(double floor, double share, const Vec3& before, const Vec3& after) {
  return std::max(floor, share * std::min(before.norm(), after.norm()));
}

Vec3 at(const Model* model, const Vec3& x) {
  return model == nullptr ? Vec3::Zero() : model->force(x);
}

}  // namespace

ForceSwitch::ForceSwitch(SwitchOptions options) : options_(options) {}

ForceSwitch::Step ForceSwitch::step(const Model* newest, const Vec3& x) noexcept {
  if (options_.rule == SwitchRule::paper) return step_paper(newest, x);
  const double travel = begun_ ? (x - last_x_).norm() : 0;
  begun_ = true;
  last_x_ = x;
  return step_smooth(newest, x, travel);
}

ForceSwitch::Step ForceSwitch::step_smooth(const Model* newest, const Vec3& x, double travel) noexcept {
  const Vec3 old = at(current_, x);
  const bool comes = newest != nullptr && newest != current_;
  Step out = step(old, comes ? newest->force(x) : old, comes, travel);
  if (comes) {
    out.released = current_;
    current_ = newest;
  }
  return out;
}

// The force here if the switch changed nothing in this frame: that of the model so far, plus the offset that remains
// after the motion.
Vec3 ForceSwitch::carried(const Vec3& old, const Vec3& now, double travel) noexcept {
  if (options_.rule == SwitchRule::none) return old;
  const double beyond = travel - options_.jump_speed * options_.frame;
  if (beyond > 0) offset_ *= std::exp(-beyond / options_.jump_length);
  if (largest_ == 0) largest_ = old.norm();  // rendered before the first step
  if (const double size = now.norm(); size > largest_) largest_ = size;
  const Vec3 force = old + offset_;
  const double size = force.norm();
  if (!(size > largest_)) return force;
  const Vec3 bounded = largest_ / size * force;
  offset_ = bounded - old;
  return bounded;
}

ForceSwitch::Step ForceSwitch::step(const Vec3& old, const Vec3& now, bool comes, double travel) noexcept {
  const double share = options_.jnd_share * options_.frame / options_.paper_interval;
  const double floor = options_.jnd_floor * options_.frame / options_.paper_interval;
  Step out;
  out.undamped = now;
  out.took_model = comes;
  const Vec3 before = carried(old, now, travel);
  if (comes) {
    out.undamped_jump = (now - old).norm();
    offset_ = before - now;
    if (!offset_.allFinite()) offset_.setZero();  // drops a force that is not finite
  }
  if (options_.rule == SwitchRule::none) {
    offset_.setZero();
  } else if (const double size = offset_.norm(); size > 0) {
    const double most = longest_step(floor, share, before, offset_ / size);
    if (size <= most)
      offset_.setZero();
    else
      offset_ *= 1 - most / size;
  }
  out.force = now + offset_;
  out.change = out.force - before;
  out.bound = bound(floor, share, before, out.force);
  return out;
}

ForceSwitch::Step ForceSwitch::step_paper(const Model* newest, const Vec3& x) noexcept {
  Step out;
  const Model* latest = waiting_ != nullptr ? waiting_ : current_;
  if (newest != nullptr && newest != latest) {
    out.undamped_jump = (newest->force(x) - at(latest, x)).norm();
    out.took_model = true;
    out.released = waiting_;  // never used: a newer model replaces it
    waiting_ = newest;
    latest = newest;
  }
  if (weight_ >= 1 && waiting_ != nullptr) {  // the previous switch is complete
    out.released_too = previous_;
    previous_ = current_;
    current_ = waiting_;
    waiting_ = nullptr;
    weight_ = 0;
  }
  const Vec3 to = at(current_, x);
  const Vec3 difference = weight_ < 1 ? Vec3(to - at(previous_, x)) : Vec3::Zero();
  const Vec3 before = to - (1 - weight_) * difference;
  const int interval = std::max(1, static_cast<int>(std::lround(options_.paper_interval / options_.frame)));
  if (frames_since_step_ < interval) ++frames_since_step_;
  if (weight_ < 1 && frames_since_step_ >= interval) {
    const double size = difference.norm(),
                 most = allowed(options_.jnd_floor, options_.jnd_share, before.norm());
    weight_ = (1 - weight_) * size <= most ? 1 : std::min(1.0, weight_ + most / size);
    frames_since_step_ = 0;
    if (weight_ >= 1) {
      (out.released == nullptr ? out.released : out.released_too) = previous_;
      previous_ = nullptr;
    }
  }
  out.force = to - (1 - weight_) * difference;
  out.undamped = latest == current_ ? to : at(latest, x);
  out.change = out.force - before;
  out.bound = bound(options_.jnd_floor, options_.jnd_share, before, out.force);
  return out;
}

}  // namespace forefeel
