#include "scheduling/render/safety.hpp"
#include "tests/support/test.hpp"

namespace {

const SafetyOptions plain{.force_limit = 5, .slew_limit = 1e9, .ramp_seconds = 0, .stale_seconds = 0.5};

}  // namespace

TEST_CASE("an ordinary force passes untouched") {
  Safety safety(plain, 1e-3);
  const Vec3 f(1, -2, 0.5);
  CHECK(safety.apply(f, Vec3::Zero(), 1, 0.1) == f);
  CHECK(safety.counts().clamped + safety.counts().slewed + safety.counts().stale +
            safety.counts().non_finite ==
        0);
}

TEST_CASE("clamp: the direction stays, the size does not exceed the limit") {
  Safety safety(plain, 1e-3);
  const Vec3 f = safety.apply(Vec3(30, 40, 0), Vec3::Zero(), 1, 0);
  CHECK(f.isApprox(Vec3(3, 4, 0)));
  CHECK(safety.counts().clamped == 1);
}

TEST_CASE("slew: no step larger than the limit allows, and the force arrives in the end") {
  SafetyOptions options = plain;
  options.slew_limit = 100;
  Safety safety(options, 1e-3);
  Vec3 last = Vec3::Zero();
  for (int k = 0; k < 40; ++k) {
    const Vec3 f = safety.apply(Vec3(3, 0, 0), Vec3::Zero(), 1, 0);
    CHECK((f - last).norm() <= 0.1 * (1 + 1e-12));
    last = f;
  }
  CHECK(last == Vec3(3, 0, 0));
  CHECK(safety.counts().slewed >= 29);
  CHECK(safety.counts().slewed <= 30);
}

TEST_CASE("ramp: nothing at the start, all of it at its end") {
  SafetyOptions options = plain;
  options.ramp_seconds = 0.1;
  Safety safety(options, 1e-3);
  CHECK(safety.apply(Vec3(1, 0, 0), Vec3::Zero(), 0, 0) == Vec3::Zero());
  CHECK(safety.apply(Vec3(1, 0, 0), Vec3::Zero(), 0.05, 0).isApprox(Vec3(0.5, 0, 0)));
  CHECK(safety.apply(Vec3(1, 0, 0), Vec3::Zero(), 0.1, 0) == Vec3(1, 0, 0));
}

TEST_CASE("watchdog: without a planner the force fades out, with it again in") {
  Safety safety(plain, 1e-3);
  CHECK(safety.apply(Vec3(1, 0, 0), Vec3::Zero(), 1, 0.5) == Vec3(1, 0, 0));
  double last = 1;
  for (int k = 0; k < 250; ++k) {
    const double f = safety.apply(Vec3(1, 0, 0), Vec3::Zero(), 1, 0.6).x();
    CHECK(f <= last);
    last = f;
  }
  CHECK(last == 0);
  CHECK(safety.counts().stale == 250);
  for (int k = 0; k < 250; ++k) last = safety.apply(Vec3(1, 0, 0), Vec3::Zero(), 1, 0).x();
  CHECK(last == 1);
  CHECK(safety.counts().stale == 250);
}

TEST_CASE("guard: what is not finite never reaches the device") {
  SafetyOptions options = plain;
  options.slew_limit = 1000;
  Safety safety(options, 1e-3);
  for (int k = 0; k < 5; ++k) safety.apply(Vec3(2, 0, 0), Vec3::Zero(), 1, 0);
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinite = std::numeric_limits<double>::infinity();
  for (const Vec3& bad : {Vec3(nan, 0, 0), Vec3(0, infinite, 0), Vec3(0, 0, -infinite)}) {
    const Vec3 f = safety.apply(bad, Vec3::Zero(), 1, 0);
    CHECK(f.allFinite());
  }
  CHECK(safety.counts().non_finite == 3);
  CHECK(safety.apply(Vec3(2, 0, 0), Vec3::Zero(), 1, 0).allFinite());
}

TEST_CASE("energy: a spring gives nothing it did not get, an active body does") {
  Safety spring(plain, 1e-3), active(plain, 1e-3);
  double gross = 0;
  for (int k = 0; k <= 4000; ++k) {
    const double angle = 2 * M_PI * k / 1000.0;
    const Vec3 x(0.01 * (1 - std::cos(angle)), 0.005 * std::sin(angle), 0);
    spring.apply(-100 * x, x, 1, 0);
    // A force that turns with the motion puts energy in at every loop: curl c gives c times the area
    // enclosed.
    active.apply(Vec3(20 * x.y(), -20 * (x.x() - 0.01), 0), x, 1, 0);
    if (k == 1000) gross = spring.work();
  }
  CHECK(spring.generated() < 1e-12);
  CHECK(gross > 0.5 * 100 * 0.02 * 0.02);
  const double expected = 4 * 40 * M_PI * 0.01 * 0.005;
  CHECK(active.generated() == Approx(expected).epsilon(0.01));
}
