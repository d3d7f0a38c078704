#include "small_body.hpp"

TEST_CASE(
    "a session with a hand: the body holds it back, the profile clamps, and the run repeats to the bit") {
  SessionOptions options = virtual_options(1.5);
  options.workers.cost = ConstantCost{0.005};
  options.workers.count = 4;
  options.motion.device = PathMotion{.path = PathName::press, .speed = 0.06};
  const SessionResult free = run_session(small_input(), options);
  options.motion.device =
      HandMotion{.profile = HandName::touch, .target = {.path = PathName::press, .speed = 0.06}, .grip = 100};
  const SessionResult held = run_session(small_input(), options);
  const SessionResult again = run_session(small_input(), options);
  REQUIRE(held.frames.size() == free.frames.size());
  double reach_free = 0, reach_held = 0, most = 0;
  for (std::size_t k = 0; k < held.frames.size(); ++k) {
    REQUIRE(held.frames[k].at == again.frames[k].at);
    REQUIRE(held.frames[k].force == again.frames[k].force);
    reach_free = std::max(reach_free, free.frames[k].at.norm());
    reach_held = std::max(reach_held, held.frames[k].at.norm());
    most = std::max(most, held.frames[k].sent.norm());
  }
  CHECK(reach_held < 0.95 * reach_free);
  CHECK(most > 0);
  CHECK(most <= 3.3 * (1 + 1e-12));
}

TEST_CASE("a policy that knows the motion is refused where the motion answers the force") {
  SessionOptions options = virtual_options(0.2);
  options.planning.policy = "clairvoyant";
  options.motion.device = HandMotion{.profile = HandName::omega};
  CHECK_THROWS_WITH(make_plan(small_input(), options), Contains("depends on the force", "path:NAME"));
}

TEST_CASE(
    "rest known from the start: the body's tangent is felt at once, and costs no solve of the session") {
  SessionOptions options = virtual_options(0.5);
  options.workers.cost = ConstantCost{10};  // nothing else is solved in time
  options.motion.device = PathMotion{.path = PathName::press, .speed = 0.01};
  options.judging.reference_step = 1e-4;
  options.model.first_guess = false;
  const SessionResult empty = run_session(small_input(), options);
  options.model.first_guess = true;  // not where something is known
  options.planning.rest_known = true;
  const SessionResult known = run_session(small_input(), options);
  CHECK(empty.counts.start == 0);
  CHECK(known.counts.start == 1);
  CHECK(known.counts.solved == 0);
  REQUIRE(known.states.size() == 1);
  const Mat3 stiffness = known.states.front().stiffness;
  for (const FrameRecord& frame : empty.frames) REQUIRE(frame.force == Vec3::Zero());
  for (const FrameRecord& frame : known.frames)
    REQUIRE((frame.force + stiffness * frame.at).norm() <=
            1e-3 * (stiffness * frame.at).norm() + 1e-12);  // nothing fades in
}
