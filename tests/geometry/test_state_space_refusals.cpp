// States that a state space refuses.

#include <catch2/catch.hpp>

#include <limits>
#include <string>

#include "geometry/common/error.hpp"
#include "geometry/coverage/state_space.hpp"

using namespace forefeel;

namespace {

State measured(const Vec3& at, const Vec3& force) {
  State state;
  state.at = at;
  state.force = force;
  return state;
}

std::string refusal(StateSpace& space, const State& state) {
  try {
    space.insert(state);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a state space refuses what is not usable or not finite, and stays as it was") {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  StateSpace space({.spacing = 0.006, .box = {Vec3::Constant(-0.02), Vec3::Constant(0.02)}});
  REQUIRE(space.insert(measured({0, 0, 0}, {1, 0, 0})).is_new);
  State failed = measured({0.006, 0, 0}, {1, 0, 0});
  failed.solve.status = SolveStatus::diverged;
  CHECK_THAT(refusal(space, failed), Catch::Contains("ended as diverged"));
  CHECK_THAT(refusal(space, measured({unknown, 0, 0}, {1, 0, 0})), Catch::Contains("position is not finite"));
  CHECK_THAT(refusal(space, measured({0, infinite, 0}, {1, 0, 0})),
             Catch::Contains("position is not finite"));
  CHECK_THAT(refusal(space, measured({0.006, 0, 0}, {1, infinite, 0})),
             Catch::Contains("force is not finite"));
  CHECK_THAT(refusal(space, measured({0.006, 0, 0}, {1, unknown, 0})),
             Catch::Contains("force is not finite"));
  CHECK(space.size() == 1);
  CHECK(space.insert(measured({0.006, 0, 0}, Vec3::Constant(unknown))).is_new);  // a place without a force
}
