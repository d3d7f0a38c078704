// Passivity control: the published boundaries against a sweep of gains, and springs that generate energy.

#include "scheduling/motion/device.hpp"
#include "scheduling/motion/hand_device.hpp"
#include "scheduling/motion/loop_limit.hpp"
#include "scheduling/record/stability.hpp"
#include "scheduling/render/safety.hpp"
#include "scheduling/session/passivity_plan.hpp"
#include "tests/support/free_swing.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double frame = 1e-3;
constexpr HandName every_profile[] = {HandName::touch, HandName::premium, HandName::omega, HandName::falcon};

struct Press final : Device {
  Vec3 position(double t, const Vec3&) noexcept override {
    return {0.003 * std::sin(2 * t), 0, -0.01 * (1 - std::cos(6 * t))};
  }
  double duration() const override { return 1e9; }
};

struct Held {
  StabilityReport verdict;
  PassivityReport control;
  double added = 0;  // largest force that the control took or gave [N]
};

// Stiffness of a spring at a position and time [N/m].
using Stiffness = std::function<double(double)>;

// 3 s of a spring in the loop with a device in a hand.
Held held(const HandProfile& profile, double grip, const Stiffness& stiffness, Passivity passivity) {
  const auto hand = make_hand_device(profile, std::make_unique<Press>(), {.grip = grip});
  const SafetyOptions rules{.force_limit = profile.force_limit, .passivity = passivity};
  PassivityControl control(passivity_options(rules, hand->limits(), frame), frame);
  Safety safety(rules, frame), without(rules, frame);
  std::vector<FrameRecord> frames;
  Vec3 sent = Vec3::Zero();
  Held out;
  for (int k = 0; k < 3000; ++k) {
    FrameRecord f{.t = k * frame, .at = hand->position(k * frame, sent)};
    const double spring = stiffness(f.t);
    f.force = f.undamped = -spring * f.at;
    SafetyMoment moment{.t = f.t};
    const Vec3 plain = without.apply(f.force, f.at, moment);
    if (passivity == Passivity::control) {
      control.note_model(f.at, {f.force, 0.5 * f.force, -spring * Mat3::Identity()}, false);
      moment.control = &control;
    }
    f.sent = sent = safety.apply(f.force, f.at, moment);
    out.added = std::max(out.added, (sent - plain).norm());
    frames.push_back(f);
  }
  out.verdict = judge_stability(frames, {.resolution = profile.resolution}, frame);
  out.control = control.report();
  return out;
}

Stiffness always(double stiffness) {
  return [stiffness](double) { return stiffness; };
}

LoopPlant plant_of(const HandProfile& profile, double grip) {
  return make_hand_device(profile, std::make_unique<Press>(), {.grip = grip})->limits().plant;
}

}  // namespace

TEST_CASE("the exact boundary of the sampled loop is that of a simulation by small steps") {
  for (const LoopPlant& plant : {LoopPlant{.mass = 0.1, .damping = 4.427, .stiffness = 100},
                                 LoopPlant{.mass = 0.1, .damping = 12.52, .stiffness = 800},
                                 LoopPlant{.mass = 0.05, .damping = 1, .stiffness = 300},
                                 LoopPlant{.mass = 0.2, .damping = 30, .stiffness = 500}}) {
    const double limit = sampled_limit(plant, frame);
    CAPTURE(plant.mass, plant.damping, plant.stiffness, limit);
    CHECK_FALSE(test::free_swing_grows(plant, 0.98 * limit, frame));
    CHECK(test::free_swing_grows(plant, 1.02 * limit, frame));
    // Colgate's bound is sufficient, and close to the exact one while frames are short.
    CHECK(colgate_limit(plant, frame) <= limit);
    CHECK(hulin_limit(plant, frame) == Approx(colgate_limit(plant, frame)));
  }
  const LoopPlant plant{.mass = 0.1, .damping = 4, .stiffness = 100, .resolution = 1e-5, .friction = 0.05};
  CHECK(colgate_limit(plant, frame, 1) == Approx(6000));
  CHECK(hulin_limit(plant, frame, 0.5e-3) == Approx(4000));
  CHECK(friction_limit(plant) == Approx(1e4));
  CHECK(std::isnan(sampled_limit({}, frame)));
}

TEST_CASE("a sweep of gains finds the published boundary for every profile and grip") {
  for (const HandName name_of : every_profile) {
    const HandProfile& profile = profile_of(name_of);
    for (const double grip : {100.0, 300.0, 800.0}) {
      double stable = 100, unstable = 98e3;
      CHECK_FALSE(held(profile, grip, always(unstable), Passivity::observe).verdict.stable);
      while (unstable / stable > 1.02) {
        const double middle = std::sqrt(stable * unstable);
        (held(profile, grip, always(middle), Passivity::observe).verdict.stable ? stable : unstable) = middle;
      }
      const LoopPlant plant = plant_of(profile, grip);
      // One step of the encoder may ask for no more than the slew limit of 1000 N/s lets through in a frame.
      const double published = std::min(sampled_limit(plant, frame), 1000 * frame / profile.resolution);
      CAPTURE(name(name_of), grip, stable, colgate_limit(plant, frame), sampled_limit(plant, frame),
              published);
      CHECK(stable > 0.75 * published);
      CHECK(stable < 1.15 * published);
    }
  }
}

TEST_CASE(
    "with control every spring up to 98 kN/m is stable in every device and hand, and soft ones are as "
    "without") {
  for (const HandName name_of : every_profile) {
    const HandProfile& profile = profile_of(name_of);
    for (const double grip : {100.0, 300.0, 800.0})
      for (const double spring : {500.0, 2000.0, 8000.0, 20e3, 98e3}) {
        const Held on = held(profile, grip, always(spring), Passivity::control);
        CAPTURE(name(name_of), grip, spring, on.control.coupling, on.control.lowest, on.verdict.amplitude);
        CHECK(on.verdict.stable);
        CHECK(on.verdict.generated <= 0);
        CHECK(std::isnan(on.verdict.growth));
        if (spring <= 0.7 * on.control.coupling) CHECK(on.added <= 1e-12);
        if (spring > on.control.coupling) CHECK(on.control.coupled > 0);
      }
  }
}

TEST_CASE("the tank holds back what a switch would generate: a body that is stiffer on the way out") {
  // Stiffer on the way out: every period would generate the difference of the stored energies.
  const auto stiffer_outside = [](double t) { return std::fmod(6 * t, 2 * M_PI) < M_PI ? 500.0 : 700.0; };
  for (const HandName name_of : every_profile)
    for (const double grip : {100.0, 300.0, 800.0}) {
      const HandProfile& profile = profile_of(name_of);
      const Held off = held(profile, grip, stiffer_outside, Passivity::observe);
      const Held on = held(profile, grip, stiffer_outside, Passivity::control);
      CAPTURE(name(name_of), grip, off.verdict.generated, on.verdict.generated, on.control.lowest);
      CHECK(off.verdict.generated > 1e-3);
      CHECK(off.added <= 0);
      CHECK(on.verdict.stable);
      CHECK(on.verdict.generated <= 0);
      CHECK(on.control.drained > 0);
    }
}

TEST_CASE("a switch is charged for what it adds to the stored energy, of the force that can be sent") {
  const double limit = 8, stiffness = 1e4;
  PassivityControl control({.mode = Passivity::control, .force_limit = limit}, frame);
  const Vec3 x(0, 0, -0.01);
  const auto take = [&](double k) {
    control.note_model(x, {-k * x, -0.5 * k * x, -k * Mat3::Identity()}, true);
    control.shape(-k * x, x);
  };
  // A spring of 10 kN/m would send 100 N: clamped to 8 N its energy on the way home is 8 N * 10 mm, less the first
  // part.
  take(stiffness);
  const double clamped = limit * 0.01 * (1 - 0.5 * limit / (stiffness * 0.01));
  CHECK(control.report().refused == Approx(clamped));
  for (int i = 0; i < 100; ++i) take(stiffness);  // the same again adds nothing
  CHECK(control.report().refused == Approx(clamped));
  take(stiffness / 2);  // nor does a softer one
  CHECK(control.report().refused == Approx(clamped));
}

TEST_CASE("the controller stays within slew and force limits") {
  const SafetyOptions rules{
      .force_limit = 2, .slew_limit = 100, .ramp_seconds = 0, .passivity = Passivity::control};
  PassivityControl control({.mode = Passivity::control, .force_limit = 2}, frame);
  Safety safety(rules, frame);
  Vec3 before = Vec3::Zero();
  for (int k = 0; k < 2000; ++k) {
    // A force that pushes along the motion: nothing but generation.
    const double x = 0.01 * std::sin(0.02 * k), v = std::cos(0.02 * k);
    const Vec3 sent =
        safety.apply(Vec3(5 * v, 0, 0), Vec3(x, 0, 0), SafetyMoment{.t = k * frame, .control = &control});
    CHECK((sent - before).norm() <= 0.1 * (1 + 1e-9));
    CHECK(sent.norm() <= 2 * (1 + 1e-9));
    before = sent;
  }
  CHECK(control.report().controlled > 100);
  CHECK(control.report().dissipated > 0);
}
