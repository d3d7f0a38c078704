#include "scheduling/motion/hand_device.hpp"

#include <cmath>

#include "scheduling/motion/device.hpp"

namespace forefeel {
namespace {

constexpr HandProfile profiles[] = {
    {.name = HandName::touch, .force_limit = 3.3, .stiffness = 700, .resolution = 55e-6},
    {.name = HandName::premium, .force_limit = 8.5, .stiffness = 3500, .resolution = 30e-6},
    {.name = HandName::omega, .force_limit = 12, .stiffness = 5000, .resolution = 10e-6},
    {.name = HandName::falcon, .force_limit = 8, .stiffness = 3000, .resolution = 63e-6},
};

class HandDevice final : public Device {
 public:
  HandDevice(const HandProfile& profile, std::unique_ptr<Device> target, const HandOptions& options)
      : profile_(profile),
        target_(std::move(target)),
        grip_(options.grip),
        zeta_(options.damping_ratio),
        omega_(std::sqrt(options.grip / options.mass)) {
    reset();
  }

  Vec3 position(double t, const Vec3& force) noexcept override {
    if (t < last_t_) reset();
    if (t > last_t_) step(t, force);
    return measured();
  }
  double duration() const override { return target_->duration(); }
  bool answers_force() const override { return true; }
  DeviceLimits limits() const override {
    return {.force = profile_.force_limit,
            .stiffness = profile_.stiffness,
            .plant = {.mass = grip_ / (omega_ * omega_),
                      .damping = 2 * zeta_ * grip_ / omega_,
                      .stiffness = grip_,
                      .resolution = profile_.resolution}};
  }

 private:
  void reset() noexcept {
    last_t_ = 0;
    target_at_ = target_->position(0, Vec3::Zero());
    x_ = target_at_;
    v_.setZero();
  }

  // With y = x - x_t - F / k the equation is y'' + 2 zeta omega y' + omega^2 y = 0, omega^2 = k / m.
  void step(double t, const Vec3& force) noexcept {
    const double dt = t - last_t_;
    const Vec3 next = target_->position(t, Vec3::Zero());
    const Vec3 target_v = (next - target_at_) / dt;
    const Vec3 yielded = force / grip_;
    const Vec3 y = x_ - target_at_ - yielded, dy = v_ - target_v;
    const double decay = std::exp(-zeta_ * omega_ * dt), damped = omega_ * std::sqrt(1 - zeta_ * zeta_);
    const double c = std::cos(damped * dt), s = std::sin(damped * dt) / damped;
    x_ = next + yielded + decay * ((c + zeta_ * omega_ * s) * y + s * dy);
    v_ = target_v + decay * ((c - zeta_ * omega_ * s) * dy - omega_ * omega_ * s * y);
    target_at_ = next;
    last_t_ = t;
  }

  Vec3 measured() const noexcept {
    const double r = profile_.resolution;
    return {r * std::nearbyint(x_[0] / r), r * std::nearbyint(x_[1] / r), r * std::nearbyint(x_[2] / r)};
  }

  HandProfile profile_;
  std::unique_ptr<Device> target_;
  double grip_, zeta_, omega_;
  double last_t_ = 0;
  Vec3 x_ = Vec3::Zero(), v_ = Vec3::Zero(), target_at_ = Vec3::Zero();
};

}  // namespace

const HandProfile& profile_of(HandName hand) {
  for (const HandProfile& profile : profiles)
    if (profile.name == hand) return profile;
  return profiles[0];
}

std::unique_ptr<Device> make_hand_device(const HandProfile& profile, std::unique_ptr<Device> target,
                                         const HandOptions& options) {
  return std::make_unique<HandDevice>(profile, std::move(target), options);
}

}  // namespace forefeel
