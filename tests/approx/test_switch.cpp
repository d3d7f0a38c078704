#include "approx/switch/force_switch.hpp"
#include "tests/approx/sets.hpp"
#include "tests/support/test.hpp"

namespace {

// Models of scaled copies of the field, so that successive ones disagree by any amount.
std::vector<std::unique_ptr<Model>> models(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<std::unique_ptr<Model>> made;
  for (std::size_t i = 0; i < count; ++i) {
    auto states = states_at(lattice_points(1, 0.01));
    const double factor = 1 + 2 * unit(random);
    const Vec3 offset = 0.5 * Vec3(unit(random), unit(random), unit(random));
    for (auto& s : states) s.force = factor * s.force + offset;
    made.push_back(std::make_unique<Model>(fit_model(states, {.kernel = Kernel::cubic}, Vec3::Zero())));
  }
  return made;
}

}  // namespace

TEST_CASE("No frame changes the force by more than the rule's bound, whatever models come") {
  const auto known = models(12, 3);
  for (const SwitchRule rule : {SwitchRule::paper, SwitchRule::smooth})
    for (unsigned seed = 0; seed < 20; ++seed) {
      CAPTURE(name(rule), seed);
      std::mt19937 random(seed);
      ForceSwitch damped({.rule = rule});
      const double share = rule == SwitchRule::paper ? 0.07 : 0.007,
                   floor = rule == SwitchRule::paper ? 0.01 : 0.001;
      Vec3 x(0.004, 0, 0);
      const Model* newest = nullptr;
      int since_change = 0;
      for (int frame = 0; frame < 3000; ++frame) {
        x += 2e-5 * Vec3(std::sin(0.01 * frame), std::cos(0.013 * frame), std::sin(0.007 * frame + 1));
        const bool comes = random() % 50 == 0;
        if (comes) newest = known[random() % known.size()].get();
        const auto out = damped.step(comes ? newest : nullptr, x);
        const double after = out.force.norm(), before = (out.force - out.change).norm(),
                     moved = out.change.norm();
        CHECK(moved <= std::max(floor, share * after) * (1 + 1e-12) + 1e-15);
        CHECK(moved <= std::max(floor, share * before) * (1 + 1e-12) + 1e-15);
        CHECK(moved <= out.bound);
        if (rule == SwitchRule::paper) {  // at most one step in ten frames
          since_change = moved > 1e-12 ? 0 : since_change + 1;
          if (moved <= 1e-12 && since_change < 9) CHECK(moved <= 1e-12);
        }
      }
    }
}

TEST_CASE("The paper's weight moves every tenth frame") {
  const auto known = models(2, 8);
  ForceSwitch damped({.rule = SwitchRule::paper});
  const Vec3 x(0.005, 0.002, 0);
  int last = -100;
  for (int frame = 0; frame < 2000; ++frame) {
    const auto out = damped.step(frame == 3 ? known[0].get() : frame == 700 ? known[1].get() : nullptr, x);
    if (out.change.norm() < 1e-14) continue;
    CHECK(frame - last >= 10);
    last = frame;
  }
  CHECK(last > 700);
}

TEST_CASE("The first model fades in from zero and the force converges to the newest model") {
  const auto known = models(3, 5);
  for (const SwitchRule rule : {SwitchRule::paper, SwitchRule::smooth, SwitchRule::none}) {
    CAPTURE(name(rule));
    ForceSwitch damped({.rule = rule});
    const Vec3 x(0.005, 0.002, -0.001);
    CHECK(damped.step(nullptr, x).force.norm() == 0);
    auto out = damped.step(known[0].get(), x);
    CHECK(out.took_model);
    CHECK(out.undamped_jump == Approx(known[0]->force(x).norm()));
    if (rule != SwitchRule::none) CHECK(out.force.norm() <= 0.010 * (1 + 1e-12));
    for (int i = 0; i < 4000; ++i) out = damped.step(i == 2000 ? known[1].get() : nullptr, x);
    CHECK((out.force - known[1]->force(x)).norm() < 1e-12);
    CHECK((out.undamped - known[1]->force(x)).norm() < 1e-12);
  }
}

TEST_CASE("Every model is released exactly once, and the latest wins") {
  const auto known = models(40, 6);
  for (const SwitchRule rule : {SwitchRule::paper, SwitchRule::smooth, SwitchRule::none}) {
    CAPTURE(name(rule));
    ForceSwitch damped({.rule = rule});
    std::vector<int> released(known.size(), 0);
    const auto count = [&](const Model* model) {
      for (std::size_t i = 0; i < known.size(); ++i) released[i] += known[i].get() == model ? 1 : 0;
    };
    const Vec3 x(0.005, 0.002, -0.001);
    ForceSwitch::Step out;
    for (std::size_t frame = 0; frame < 6000; ++frame) {
      const bool comes = frame % 7 == 0 && frame / 7 < known.size();
      out = damped.step(comes ? known[frame / 7].get() : nullptr, x);
      if (out.released != nullptr) count(out.released);
      if (out.released_too != nullptr) count(out.released_too);
      int living = 0;
      for (std::size_t i = 0; i < std::min(known.size(), frame / 7 + 1); ++i)
        living += released[i] == 0 ? 1 : 0;
      CHECK(living <= (rule == SwitchRule::paper ? 3 : 1));
    }
    for (std::size_t i = 0; i + 1 < known.size(); ++i) CHECK(released[i] == 1);
    CHECK(released.back() == 0);
    CHECK((out.force - known.back()->force(x)).norm() < 1e-12);
  }
}

TEST_CASE("The smooth offset is gone in the stated time") {
  const auto known = models(2, 12);
  ForceSwitch damped({.rule = SwitchRule::smooth});
  const Vec3 x(0.005, 0.002, -0.001);
  for (int i = 0; i < 5000; ++i) damped.step(i == 0 ? known[0].get() : nullptr, x);
  auto out = damped.step(known[1].get(), x);
  const int limit = static_cast<int>(std::ceil(out.undamped_jump / 0.001));
  int frames = 1;
  while ((out.force - out.undamped).norm() > 0) {
    out = damped.step(nullptr, x);
    REQUIRE(++frames <= limit + 1);
  }
}

TEST_CASE("The smooth rule uses its whole bound until the offset is gone, whether the force grows or falls") {
  const auto known = models(2, 12);
  for (const bool grows : {true, false}) {
    CAPTURE(grows);
    ForceSwitch damped({.rule = SwitchRule::smooth});
    const Vec3 small(0.1, 0.02, 0), large(3, -1, 0.5);
    auto out = damped.step(Vec3::Zero(), grows ? small : large, true);
    for (int i = 0; i < 4000; ++i) out = damped.step(grows ? small : large, grows ? small : large, false);
    REQUIRE(out.change.norm() == 0);
    out = damped.step(out.force, grows ? large : small, true);
    int frames = 0;
    while ((out.force - out.undamped).norm() > 0.03) {
      const Vec3 before = out.force;
      out = damped.step(out.undamped, out.undamped, false);
      const double least = std::min(before.norm(), out.force.norm());
      CHECK(out.change.norm() <= out.bound);
      CHECK(out.change.norm() >= (1 - 1e-6) * std::max(0.001, 0.007 * least));
      REQUIRE(++frames < 5000);
    }
    CHECK(frames > 100);
  }
}

TEST_CASE("Forces given instead of models are switched alike") {
  const auto known = models(3, 5);
  ForceSwitch by_model, by_force;
  const Model* current = nullptr;
  for (int k = 0; k < 600; ++k) {
    const Vec3 x(0.004 + 1e-5 * k, 0.002, -0.001);
    const Model* newest = k % 200 == 5 ? known[static_cast<std::size_t>(k / 200)].get() : nullptr;
    const Vec3 old = current == nullptr ? Vec3::Zero() : current->force(x);
    const auto a = by_model.step(newest, x);
    const auto b = by_force.step(old, newest == nullptr ? old : newest->force(x), newest != nullptr);
    if (newest != nullptr) current = newest;
    CHECK(a.force == b.force);
    CHECK(a.change == b.change);
    CHECK(a.undamped_jump == b.undamped_jump);
  }
}

TEST_CASE("Whatever jumps the HIP makes, the smooth force is never larger than the largest of the models") {
  const auto known = models(12, 3);
  for (const double jump : {0.05, 0.002, 0.0005}) {
    CAPTURE(jump);
    double smooth = 0, none = 0;
    for (const SwitchRule rule : {SwitchRule::smooth, SwitchRule::none}) {
      std::mt19937 random(5);
      ForceSwitch damped({.rule = rule});
      double largest = 0;
      for (int frame = 0; frame < 4000; ++frame) {
        const double side = frame / 10 % 2 == 0 ? 0.5 : -0.5;
        const Vec3 x = Vec3(side * jump, 0.2 * side * jump, 0.001);
        const bool comes = frame % 10 == 3;
        const auto out = damped.step(comes ? known[random() % known.size()].get() : nullptr, x);
        largest = std::max(largest, out.force.norm());
        if (rule == SwitchRule::smooth) CHECK(out.change.norm() <= out.bound);
      }
      (rule == SwitchRule::smooth ? smooth : none) = largest;
    }
    CHECK(none > 0);
    CHECK(smooth <= none * (1 + 1e-9));
  }
}

TEST_CASE("After a jump of 5 cm nothing is left of the offset that was measured before it") {
  const auto known = models(2, 12);
  ForceSwitch damped({.rule = SwitchRule::smooth});
  const Vec3 deep(0.005, 0.002, -0.001), far(-0.04, 0.01, 0);
  for (int i = 0; i < 5000; ++i) damped.step(i == 0 ? known[0].get() : nullptr, deep);
  const auto before = damped.step(known[1].get(), deep);
  const double offset = (before.force - before.undamped).norm();
  REQUIRE(offset > 0.1);
  const auto after = damped.step(nullptr, far);
  CHECK((after.force - after.undamped).norm() < 1e-4 * offset);
  CHECK(after.change.norm() <= after.bound);
}

TEST_CASE("A force that is not finite leaves no offset behind") {
  ForceSwitch damped;
  damped.step(Vec3::Zero(), Vec3::Constant(std::nan("")), true);
  const auto out = damped.step(Vec3::Constant(std::nan("")), Vec3(1, 0, 0), true);
  CHECK(out.force == Vec3(1, 0, 0));
}
