#include "block_body.hpp"
#include "tests/support/test.hpp"

namespace {

const double h = 0.006;

std::vector<Vec3> neighbours(const Vec3& x) {
  std::vector<Vec3> all;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) all.push_back(x + sign * h * Vec3::Unit(axis));
  all.push_back(x + h * Vec3(1, 1, 0));
  all.push_back(x + h * Vec3(1, 1, 1));
  all.push_back(x - h * Vec3(0, 1, 1));  // a ninth: a second group of lanes
  return all;
}

}  // namespace

TEST_CASE("states beside a known one equal tight solves along the straight path, every law and element") {
  for (const Law law : all_laws())
    for (const Element element : {Element::linear, Element::quadratic}) {
      INFO(name(law) << " " << name(element));
      Solver solver(block_body(law, 0.4, 1, element)), judge(block_body(law, 0.4, 1, element));
      const Vec3 x(-0.012, 0.006, 0);
      SolveOptions options;
      options.tolerance = 1e-6;
      options.keep_factor = true;
      const SolveOutcome near = solver.from(*solver.rest(), x, options);
      REQUIRE(near.equilibrium);
      const std::vector<Vec3> xs = neighbours(x);
      const std::vector<SolveOutcome> found = solver.beside(*near.equilibrium, xs, options);
      REQUIRE(found.size() == xs.size());
      for (std::size_t i = 0; i < xs.size(); ++i) {
        const State state = judge.reference(xs[i], h).state;
        CAPTURE(i);
        REQUIRE(found[i].state.solve.status == SolveStatus::converged);
        REQUIRE(found[i].equilibrium);
        CHECK(found[i].state.at == xs[i]);
        CHECK((found[i].state.force - state.force).norm() <= 5e-6 * state.force.norm());
        CHECK((found[i].state.stiffness - state.stiffness).norm() <= 3e-4 * state.stiffness.norm());
        // It is a start for others: an iteration or two from it, and the tight force.
        options.tolerance = 1e-10;
        const SolveOutcome again = judge.from(*found[i].equilibrium, xs[i], options);
        options.tolerance = 1e-6;
        CHECK(again.state.solve.iterations <= 2);
        CHECK((again.state.force - state.force).norm() <= 1e-8 * state.force.norm());
      }
    }
}

TEST_CASE("states beside one whose factor was lost, beside rest, none, and after a stop") {
  Solver solver(block_body(Law::neo_hookean)), other(block_body(Law::neo_hookean));
  SolveOptions options;
  options.tolerance = 1e-6;
  const Vec3 x(-0.006, 0.006, 0.006);
  const SolveOutcome near = other.reference(x, h);
  const std::vector<Vec3> xs = neighbours(x);
  for (const auto& start : {near.equilibrium, solver.rest()}) {
    const std::vector<SolveOutcome> found = solver.beside(*start, xs, options);
    for (std::size_t i = 0; i < xs.size(); ++i) {
      const State state = other.reference(xs[i], h).state;
      CHECK((found[i].state.force - state.force).norm() <= 5e-6 * state.force.norm());
    }
  }
  CHECK(solver.beside(*near.equilibrium, {}, options).empty());
  std::stop_source stop;
  stop.request_stop();
  for (const SolveOutcome& outcome : solver.beside(*near.equilibrium, xs, options, stop.get_token()))
    CHECK(outcome.state.solve.status == SolveStatus::cancelled);
}

TEST_CASE("a cancelled solve keeps its last iterate; a solve from there reaches the same equilibrium") {
  Solver solver(block_body(Law::neo_hookean, 0.45, 3)), judge(block_body(Law::neo_hookean, 0.45, 3));
  SolveOptions options;
  const Vec3 x(-0.02, 0.012, 0.004);
  const State whole = judge.from(*judge.rest(), x, options).state;
  REQUIRE(whole.usable());
  int broken_off = 0;
  for (int attempt = 0; attempt < 200 && broken_off < 3; ++attempt) {
    std::stop_source stop;
    std::thread stopper([&] {
      std::this_thread::sleep_for(
          std::chrono::duration<double>(whole.solve.seconds * (0.1 + 0.8 * (attempt % 10) / 10.0)));
      stop.request_stop();
    });
    const SolveOutcome outcome = solver.from(*solver.rest(), x, options, stop.get_token());
    stopper.join();
    if (outcome.state.solve.status != SolveStatus::cancelled) continue;  // too late
    CHECK_FALSE(outcome.equilibrium);
    if (!outcome.partial) continue;  // before the first iteration
    ++broken_off;
    const SolveOutcome rest = solver.from(*outcome.partial, x, options);
    REQUIRE(rest.state.usable());
    CHECK((rest.state.force - whole.force).norm() <= 1e-8 * whole.force.norm());
    CHECK(rest.state.solve.iterations < whole.solve.iterations);
  }
  CHECK(broken_off > 0);
}
