// The reserve of the passivity control: exact small cases, motions at random, and fast hands on bodies that are
// learned.

#include "scheduling/motion/device.hpp"
#include "scheduling/motion/hand_device.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/record/stability.hpp"
#include "scheduling/render/safety.hpp"
#include "scheduling/session/passivity_plan.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double frame = 1e-3;

double draw(std::uint64_t seed, std::uint64_t k) {  // in [-1, 1)
  return 2 * random::uniform(random::mix(seed, k)) - 1;
}

// Moves along (0.1, 0.05, -1) to a depth of 30 mm and back at a constant speed, without end.
struct Strokes final : Device {
  explicit Strokes(double v) : speed(v) {}
  Vec3 position(double t, const Vec3&) noexcept override {
    constexpr double depth = 0.03;
    const double p = std::fmod(speed * t, 2 * depth);
    return (p < depth ? p : 2 * depth - p) * Vec3(0.1, 0.05, -1).normalized();
  }
  double duration() const override { return 1e9; }
  double speed;
};

// A body of stiffness K (1 + |x|^2 / (1 cm)^2) whose model changes every 40 ms, by less and less in the first 4 s.
struct LearnedBody {
  double stiffness;  // K [N/m]
  double scale = 0;  // of the force that is rendered, which follows that of the newest model
  double newest = 0;

  ModelView view(const Vec3& x) const {
    const Mat3 shape = (Mat3() << 0.5, 0.05, 0.02, 0.05, 0.45, 0, 0.02, 0, 1).finished();
    const double k = newest * stiffness;
    const auto factor = [](const Vec3& at) { return 1 + at.squaredNorm() / 1e-4; };
    return {.here = -k * factor(x) * (shape * x),
            .half_way = -k * factor(0.5 * x) * (shape * (0.5 * x)),
            .jacobian = -k * (factor(x) * shape + (shape * x) * (2e4 * x.transpose()))};
  }
  void learn(double t, std::uint64_t k) {
    newest = t < 0.3 ? 0 : 1 + (1 - std::min(1.0, t / 4)) * 0.25 * (draw(7, k) - 0.4) + 0.01 * draw(8, k);
  }
};

StabilityReport pressed(const HandProfile& profile, double grip, double speed, double stiffness,
                        Passivity passivity) {
  const auto hand = make_hand_device(profile, std::make_unique<Strokes>(speed), {.grip = grip});
  const SafetyOptions rules{.force_limit = profile.force_limit, .passivity = passivity};
  PassivityControl control(passivity_options(rules, hand->limits(), frame), frame);
  Safety safety(rules, frame);
  LearnedBody body{.stiffness = stiffness};
  std::vector<FrameRecord> frames;
  Vec3 sent = Vec3::Zero();
  for (std::uint64_t k = 0; k < 8000; ++k) {
    FrameRecord f{.t = static_cast<double>(k) * frame};
    f.at = hand->position(f.t, sent);
    const bool taken = k % 40 == 0;
    if (taken) body.learn(f.t, k);
    body.scale += std::clamp(body.newest - body.scale, -0.007, 0.007);
    const ModelView view = body.view(f.at);
    f.undamped = view.here;
    f.force = body.newest > 0 ? Vec3(body.scale / body.newest * view.here) : Vec3::Zero();
    SafetyMoment moment{.t = f.t};
    if (passivity == Passivity::control) {
      if (taken || control.wants_model()) control.note_model(f.at, view, taken);
      moment.control = &control;
    }
    f.sent = sent = safety.apply(f.force, f.at, moment);
    frames.push_back(f);
  }
  return judge_stability(frames, {.resolution = profile.resolution}, frame);
}

}  // namespace

TEST_CASE("a force without stored energy is that of the coupling, and a stored one may be rendered") {
  PassivityControl control({.mode = Passivity::control, .coupling = 1000}, frame);
  const ForceRoom wide{.step = 50, .size = 100};  // v / S is below 1 / K_c
  CHECK(control.settle(Vec3::Zero(), Vec3::Zero(), wide).norm() == 0);
  // From rest to 1 mm: E' = |F| dx / 2 must be |F|^2 / (2 K_c), so |F| = K_c dx.
  const Vec3 x(0, 0, -1e-3);
  const Vec3 first = control.settle(Vec3(0, 0, 10), x, wide);
  CHECK(first[2] == Approx(1));
  // It rests: E = 0.5 mJ holds 1 N, no more.
  CHECK(control.settle(Vec3(0, 0, 10), x, {.before = first, .step = 50, .size = 100})[2] == Approx(1));
  CHECK(control.settle(Vec3(0, 0, 0.5), x, {.before = first, .step = 50, .size = 100})[2] == Approx(0.5));
  // Pressed 1 mm further with 0.5 N before: E' = (0.5 + 0.25 + F / 2) mJ = F^2 / 2000, F = (1 + sqrt(7)) / 2.
  const Vec3 deeper = control.settle(Vec3(0, 0, 10), 2 * x, {.before = {0, 0, 0.5}, .step = 50, .size = 100});
  CHECK(deeper[2] == Approx((1 + std::sqrt(7)) / 2));
  CHECK(control.report().lowest >= 0);
  CHECK(control.report().controlled == 0);
}

TEST_CASE("a hand that is too fast for the slew limit meets a spring of S / v") {
  // 0.1 m/s into a spring of 50 kN/m, with steps of 1 N a frame: K_b = 1000 N/s / (2 * 0.1 m/s) = 5 kN/m.
  PassivityControl control({.mode = Passivity::control}, frame);
  const double v = 0.1, step = 1;
  double last = 0, energy = 0;
  const auto move_to = [&](double depth, double dx) {
    const double wanted = std::min(5e4 * depth, last + step), before = last;
    const ForceRoom room{.before = {0, 0, last}, .step = step, .size = 100};
    last = control.settle(Vec3(0, 0, wanted), Vec3(0, 0, -depth), room)[2];
    energy += 0.5 * (last + before) * dx;
  };
  for (int k = 0; k < 100; ++k) {
    move_to(v * frame * k, k > 0 ? v * frame : 0);
    const double softness =
        2 * v * (1 - std::pow(0.7, k)) / 1000;  // the share of the speed that is seen by then
    if (k > 10) CHECK(energy == Approx(0.5 * last * last * softness));
  }
  for (int k = 98; k >= 0; --k) {
    move_to(v * frame * k, -v * frame);
    CHECK(energy >= 0);
  }
  CHECK(last <= step);
  CHECK(control.report().controlled == 0);
}

TEST_CASE("random motions and forces, however they change: the tank is never below the quantum") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const double resolution = seed % 2 ? 0 : 3e-5, limit = 3 + 9 * std::abs(draw(seed, 1));
    const double speed = 0.02 + 0.4 * std::abs(draw(seed, 2));
    const SafetyOptions rules{.force_limit = limit, .passivity = Passivity::control};
    PassivityControl control({.mode = Passivity::control,
                              .coupling = seed % 3 ? 5000 : std::numeric_limits<double>::infinity(),
                              .resolution = resolution,
                              .force_limit = limit},
                             frame);
    Safety safety(rules, frame);
    Vec3 x = Vec3::Zero(), heading(0, 0, -1), bias = Vec3::Zero();
    double stiffness = 0, energy = 0, most = 0, least = 0;
    Vec3 before = Vec3::Zero(), last = Vec3::Zero();
    for (std::uint64_t k = 0; k < 20000; ++k) {
      // The hand turns at random, is drawn back to rest, and its speed varies between half and all of `speed`.
      const Vec3 turn(draw(seed, 10 * k), draw(seed, 10 * k + 1), draw(seed, 10 * k + 2));
      heading = (heading + 0.05 * turn - 0.5 * x).normalized();
      if (k > 0) x += speed * frame * (0.75 + 0.25 * draw(seed, k / 50 * 10 + 3)) * heading;
      // The body changes at once, from nothing to 50 kN/m, with a part that no elastic body has.
      if (draw(seed, 10 * k + 4) > 0.98) {
        stiffness = 5e4 * std::pow(std::abs(draw(seed, 10 * k + 5)), 3);
        bias = 3 * Vec3(draw(seed, 10 * k + 6), draw(seed, 10 * k + 7), draw(seed, 10 * k + 8));
      }
      const Vec3 at = resolution > 0 ? Vec3((x / resolution).array().round() * resolution) : x;
      const Vec3 force = -stiffness * at + bias;
      control.note_model(at, {force, 0.5 * force, -stiffness * Mat3::Identity()}, true);
      const Vec3 sent =
          safety.apply(force, at, SafetyMoment{.t = static_cast<double>(k) * frame, .control = &control});
      most = std::max(most, sent.norm());
      energy = std::min(energy - 0.5 * (sent + before).dot(at - last), most * at.norm());
      least = std::min(least, energy + std::sqrt(3.0) * resolution * most);
      before = sent;
      last = at;
    }
    CAPTURE(seed, speed, limit, resolution, control.report().controlled);
    CHECK(least >= -1e-12);
    CHECK(control.report().lowest == Approx(least).margin(1e-12));
    CHECK(control.report().drained > 0);
  }
}

TEST_CASE("with control every profile and grip is stable on learned bodies at up to 0.3 m/s") {
  int unstable_without = 0;
  for (const HandName name_of : {HandName::touch, HandName::premium, HandName::omega, HandName::falcon})
    for (const double grip : {100.0, 300.0, 800.0})
      for (const double speed : {0.06, 0.15, 0.3})
        for (const double stiffness : {700.0, 2700.0, 10e3, 34e3}) {
          const HandProfile& profile = profile_of(name_of);
          unstable_without += !pressed(profile, grip, speed, stiffness, Passivity::observe).stable;
          const StabilityReport on = pressed(profile, grip, speed, stiffness, Passivity::control);
          CAPTURE(name(name_of), grip, speed, stiffness, on.since, on.amplitude);
          CHECK(on.stable);
          CHECK(on.generated <= 0);
          CHECK(std::isnan(on.growth));
        }
  CHECK(unstable_without > 100);
}
