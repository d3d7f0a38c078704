// A delay of whole frames in the loop: the boundary of stability falls as published.

#include "scheduling/motion/delayed_device.hpp"
#include "scheduling/motion/hand_device.hpp"
#include "scheduling/session/passivity_plan.hpp"
#include "small_body.hpp"
#include "tests/support/free_swing.hpp"

namespace {

constexpr double frame = 1e-3;

struct Still final : Device {
  Vec3 position(double, const Vec3&) noexcept override { return Vec3::Zero(); }
  double duration() const override { return 1e9; }
};

// Passes on what it is told.
struct Told final : Device {
  std::vector<Vec3>& forces;
  explicit Told(std::vector<Vec3>& to) : forces(to) {}
  Vec3 position(double, const Vec3& force) noexcept override {
    forces.push_back(force);
    return Vec3::Zero();
  }
  double duration() const override { return 1e9; }
};

// The same for the device itself, without rounding of positions to speak of.
bool device_grows(double grip, double stiffness, std::size_t late) {
  const HandProfile fine{.name = HandName::omega, .force_limit = 1e9, .stiffness = 1e9, .resolution = 1e-12};
  const auto hand = make_delayed_device(make_hand_device(fine, std::make_unique<Still>(), {.grip = grip}),
                                        static_cast<double>(late) * frame, frame);
  double first = 0, last = 0;
  Vec3 sent = Vec3::UnitX();  // a push to begin with
  constexpr int frames = 6000;
  for (int k = 0; k < frames; ++k) {
    const Vec3 x = hand->position(k * frame, sent);
    sent = -stiffness * x + Vec3(k < 20 ? 1 : 0, 0, 0);
    if (k >= 200) (k < frames / 2 ? first : last) = std::max(k < frames / 2 ? first : last, x.norm());
    if (!(x.norm() < 1)) return true;
  }
  return last > first;
}

LoopPlant plant_of(double grip) {
  return make_hand_device(profile_of(HandName::omega), std::make_unique<Still>(), {.grip = grip})
      ->limits()
      .plant;
}

}  // namespace

TEST_CASE("a delayed force arrives whole frames later, also where frames are skipped") {
  std::vector<Vec3> forces;
  const auto late = make_delayed_device(std::make_unique<Told>(forces), 0.003, frame);
  const auto sent = [](double f) { return Vec3(f, 0, 0); };
  for (int k = 0; k < 6; ++k) late->position(k * frame, sent(k));
  for (int k = 0; k < 6; ++k) CHECK(forces[static_cast<std::size_t>(k)] == sent(std::max(0, k - 3)));
  late->position(7 * frame, sent(6));  // frame 6 was skipped: the force of 6 was held in both
  CHECK(forces.back() == sent(4));
  late->position(8 * frame, sent(8));
  CHECK(forces.back() == sent(5));
  late->position(30 * frame, sent(9));
  CHECK(forces.back() == sent(9));
  late->position(0, sent(1));  // from the start again
  CHECK(forces.back() == sent(0));
  for (const double wrong : {-0.001, 0.0005, 0.2, std::nan("")})
    CHECK_THROWS_AS(make_delayed_device(std::make_unique<Still>(), wrong, frame), InputError);
}

TEST_CASE(
    "the boundary of stability falls with the delay, as a simulation by small steps and Hulin's condition "
    "say") {
  for (const double grip : {100.0, 300.0, 800.0}) {
    const LoopPlant plant = plant_of(grip);
    double before = std::numeric_limits<double>::infinity();
    for (const std::size_t late : {0u, 1u, 2u, 4u, 8u, 20u}) {
      const double limit = delayed_limit(plant, frame, late);
      const double published = hulin_limit(plant, frame, static_cast<double>(late) * frame);
      CAPTURE(grip, late, limit, published);
      CHECK(limit < before);
      CHECK_FALSE(test::free_swing_grows(plant, 0.98 * limit, frame, late));
      CHECK(test::free_swing_grows(plant, 1.02 * limit, frame, late));
      CHECK_FALSE(device_grows(grip, 0.97 * limit, late));
      CHECK(device_grows(grip, 1.03 * limit, late));
      CHECK(limit >= published);
      if (late <= 4) CHECK(limit <= 1.15 * published);
      before = limit;
    }
  }
}

TEST_CASE("passivity control of a delayed device keeps below its boundary") {
  SafetyOptions rules;
  rules.passivity = Passivity::control;
  for (const double delay : {0.0, 0.002, 0.008}) {
    const auto hand = make_delayed_device(
        make_hand_device(profile_of(HandName::omega), std::make_unique<Still>(), {.grip = 300}), delay,
        frame);
    const auto late = static_cast<std::size_t>(std::llround(delay / frame));
    CHECK(passivity_options(rules, hand->limits(), frame).coupling ==
          Approx(0.95 * delayed_limit(plant_of(300), frame, late)));
  }
}
