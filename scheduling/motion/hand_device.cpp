#include "scheduling/motion/hand_device.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scheduling/motion/device.hpp"
#include "scheduling/motion/random.hpp"

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
        usual_(options),
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
            .plant = {.mass = usual_.mass,
                      .damping = 2 * zeta_ * std::sqrt(usual_.grip * usual_.mass),
                      .stiffness = usual_.grip,
                      .resolution = profile_.resolution}};
  }

 private:
  // To a force that came as a surprise.
  struct Reaction {
    Vec3 expected = Vec3::Zero();  // force [N]
    double level = 0;              // [1]
    double due = 0;                // when it begins [s]
  };

  void reset() noexcept {
    last_t_ = 0;
    target_at_ = target_->position(0, Vec3::Zero());
    x_ = target_at_;
    v_.setZero();
    reaction_.expected.setZero();
    reaction_.level = 0;
    reaction_.due = std::numeric_limits<double>::infinity();
    set_grip(usual_.grip);
  }

  void set_grip(double grip) noexcept {
    grip_ = grip;
    omega_ = std::sqrt(grip / usual_.mass);
  }

  // The grip in the frame that ends at t: stiffer for a while after a force that came as a surprise.
  void react(double t, const Vec3& force) noexcept {
    constexpr double memory = 0.1;  // [s]
    const double dt = t - last_t_;
    reaction_.level *= std::exp(-dt / usual_.calm);
    if (t >= reaction_.due) {
      reaction_.level = 1;
      reaction_.due = std::numeric_limits<double>::infinity();
    }
    if ((force - reaction_.expected).norm() > usual_.surprise)
      reaction_.due = std::min(reaction_.due, t + usual_.delay);
    reaction_.expected += (1 - std::exp(-dt / memory)) * (force - reaction_.expected);
    set_grip(usual_.grip * (1 + usual_.stiffening * reaction_.level));
  }

  // With y = x - x_t - F / k the equation is y'' + 2 zeta omega y' + omega^2 y = 0, omega^2 = k / m.
  void step(double t, const Vec3& force) noexcept {
    if (usual_.stiffening > 0) react(t, force);
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
  HandOptions usual_;
  double grip_, zeta_, omega_;
  Reaction reaction_;
  double last_t_ = 0;
  Vec3 x_ = Vec3::Zero(), v_ = Vec3::Zero(), target_at_ = Vec3::Zero();
};

}  // namespace

const HandProfile& profile_of(HandName hand) {
  for (const HandProfile& profile : profiles)
    if (profile.name == hand) return profile;
  return profiles[0];
}

HandOptions options_of(const HandMotion& motion) {
  const HandTraits& traits = motion.traits;
  return {.grip = motion.grip,
          .mass = traits.mass,
          .damping_ratio = traits.damping_ratio,
          .stiffening = traits.stiffening,
          .surprise = traits.surprise,
          .delay = traits.delay,
          .calm = traits.calm};
}

std::unique_ptr<Device> make_hand_device(const HandProfile& profile, std::unique_ptr<Device> target,
                                         const HandOptions& options) {
  return std::make_unique<HandDevice>(profile, std::move(target), options);
}

HandMotion drawn_hand(const HandMotion& motion, std::uint64_t seed) {
  if (!motion.traits.drawn) return motion;
  constexpr std::uint64_t of_hands = 0x68616e6473ull;  // apart from other draws of the seed
  const auto key = [seed](std::uint64_t i) { return random::mix(random::mix(seed, of_hands), i); };
  const auto between = [&](std::uint64_t i, double low, double high) {
    return low + (high - low) * random::uniform(key(i));
  };
  HandMotion hand = motion;
  hand.grip = std::clamp(motion.grip * std::exp(0.5 * random::normal(key(0))), 100.0, 1000.0);
  hand.traits = {.mass = between(1, 0.1, 0.5),
                 .damping_ratio = between(2, 0.3, 0.8),
                 .stiffening = between(3, 0, 1),
                 .surprise = motion.traits.surprise,
                 .delay = between(4, 0.05, 0.1),
                 .calm = motion.traits.calm};
  hand.target.tremor = std::exp(between(5, std::log(50e-6), std::log(200e-6)));
  return hand;
}

}  // namespace forefeel
