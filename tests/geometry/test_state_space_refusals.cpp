// States that a state space refuses.

#include "geometry/coverage/state_space.hpp"
#include "tests/support/test.hpp"

namespace {

State measured(const Vec3& at, const Vec3& force) {
  State state;
  state.at = at;
  state.force = force;
  return state;
}

std::string refusal(StateSpace& space, const State& state) {
  return error_of([&] { space.insert(state); });
}

}  // namespace

TEST_CASE("a state space refuses what is not usable or not finite, and stays as it was") {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  StateSpace space({.spacing = 0.006, .box = {Vec3::Constant(-0.02), Vec3::Constant(0.02)}});
  REQUIRE(space.insert(measured({0, 0, 0}, {1, 0, 0})).is_new);
  State failed = measured({0.006, 0, 0}, {1, 0, 0});
  failed.solve.status = SolveStatus::diverged;
  CHECK_THAT(refusal(space, failed), Contains("ended as diverged"));
  CHECK_THAT(refusal(space, measured({unknown, 0, 0}, {1, 0, 0})), Contains("position is not finite"));
  CHECK_THAT(refusal(space, measured({0, infinite, 0}, {1, 0, 0})), Contains("position is not finite"));
  CHECK_THAT(refusal(space, measured({0.006, 0, 0}, {1, infinite, 0})), Contains("force is not finite"));
  CHECK_THAT(refusal(space, measured({0.006, 0, 0}, {1, unknown, 0})), Contains("force is not finite"));
  CHECK(space.size() == 1);
  CHECK(space.insert(measured({0.006, 0, 0}, Vec3::Constant(unknown))).is_new);  // a place without a force
}
