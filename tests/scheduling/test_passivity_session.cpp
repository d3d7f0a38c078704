// Passivity control in sessions.

#include "scheduling/record/attention.hpp"
#include "scheduling/record/summary.hpp"
#include "small_body.hpp"

TEST_CASE(
    "a body that is too stiff for the device: unstable without control, stable with it, and the price is "
    "said") {
  SessionInput input = small_input();
  auto body = std::make_shared<Body>(*input.touched.body);
  body->material.young = 2e7;
  input.touched.body = body;
  input.touched.identity = {{"mesh", "small beam"}, {"material", "stiff"}};
  SessionOptions options = virtual_options(1.5);
  options.workers.cost = ConstantCost{0.005};
  options.motion.device =
      HandMotion{.profile = HandName::omega, .target = {.path = PathName::press, .speed = 0.06}, .grip = 100};
  const SessionSummary off = summarise(run_session(input, options), input, options);
  options.safety.passivity = Passivity::control;
  const SessionSummary on = summarise(run_session(input, options), input, options);
  REQUIRE(off.energy.stability);
  REQUIRE(on.energy.stability);
  CHECK_FALSE(off.energy.stability->stable);
  CHECK(on.energy.stability->stable);
  CHECK_FALSE(off.energy.control.report.on);
  CHECK(on.energy.control.report.on);
  CHECK(on.energy.control.added_p95 > 0.01);
  CHECK(on.energy.control.coupled_share > 0.5);
  CHECK(std::ranges::any_of(attention(on), [](const std::string& line) {
    return line.find("the most that the loop of this device and hand can render") != std::string::npos;
  }));
}

TEST_CASE("where the session is stable anyway, control adds at most 1 % to the force") {
  SessionOptions options = virtual_options(3);
  options.workers.cost = ConstantCost{0.005};
  options.workers.count = 4;
  options.motion.device =
      HandMotion{.profile = HandName::omega, .target = {.path = PathName::press, .speed = 0.03}};
  options.planning.rest_known = true;
  options.safety.ramp_seconds = 0;  // what is pressed during the ramp is given back in full
  for (const Law law : {Law::linear, Law::neo_hookean}) {
    const SessionInput input = small_input(law);
    options.safety.passivity = Passivity::observe;
    const SessionSummary off = summarise(run_session(input, options), input, options);
    options.safety.passivity = Passivity::control;
    const SessionSummary on = summarise(run_session(input, options), input, options);
    CAPTURE(name(law), off.energy.stability->generated, on.energy.stability->generated);
    CHECK(off.energy.stability->stable);
    CHECK(on.energy.stability->stable);
    CHECK(on.energy.control.added_p95 <= 0.01);
  }
}

TEST_CASE("a coupling above the boundary of the loop is refused, one below is taken") {
  SessionOptions options = virtual_options(0.1);
  options.motion.device = HandMotion{.profile = HandName::omega, .grip = 100};
  options.safety.passivity = Passivity::control;
  options.safety.coupling = 2e4;
  CHECK_THROWS_WITH(make_plan(small_input(), options), Contains("limits.coupling", "expected at most 84"));
  options.safety.coupling = 2000;
  CHECK(make_plan(small_input(), options).render.passivity.coupling == 2000);
  options.safety.coupling = -1;
  CHECK_THROWS_WITH(make_plan(small_input(), options), Contains("limits.coupling"));
}
