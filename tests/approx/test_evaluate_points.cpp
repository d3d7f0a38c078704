// The points of evaluate() are made in runs along a curve, by all threads: each must be what a model of its own gives.

#include <omp.h>

#include <cmath>
#include <random>

#include "approx/methods/evaluate.hpp"
#include "approx/model/updater.hpp"
#include "geometry/coverage/state_space.hpp"
#include "tests/support/test.hpp"

namespace {

Vec3 smooth_force(const Vec3& x) {
  return {std::sin(40 * x.x()) + 2 * x.y(), std::cos(30 * x.y()) * x.z(), 5 * x.z() - std::sin(20 * x.x())};
}

std::vector<Vec3> scattered(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-0.03, 0.03);
  std::vector<Vec3> all;
  for (std::size_t i = 0; i < count; ++i) all.emplace_back(uniform(random), uniform(random), uniform(random));
  return all;
}

std::vector<State> known_states(std::size_t count) {
  const std::vector<Vec3> at = scattered(count, 1);
  std::vector<Vec3> forces;
  for (const Vec3& x : at) forces.push_back(smooth_force(x));
  return measured_states(at, forces);
}

Evaluation by_threads(int threads, const std::vector<State>& states, const std::vector<Vec3>& points,
                      const EvaluateOptions& options) {
  const int before = omp_get_max_threads();
  omp_set_num_threads(threads);
  Evaluation found = evaluate(states, points, options);
  omp_set_num_threads(before);
  return found;
}

void check_same(const Evaluation& a, const Evaluation& b) {
  REQUIRE(a.made.forces == b.made.forces);
  REQUIRE(a.made.labels == b.made.labels);
  REQUIRE(a.made.fitted == b.made.fitted);
  REQUIRE(a.made.reused == b.made.reused);
  REQUIRE(a.bars.has_value() == b.bars.has_value());
  if (a.bars) REQUIRE(a.bars->at == b.bars->at);
}

}  // namespace

TEST_CASE("evaluate: each point has the model of its own neighbours, whatever the threads") {
  const std::vector<State> states = known_states(400);
  std::vector<Vec3> points = scattered(500, 2);
  for (std::size_t i = 0; i < 200; ++i)
    points.push_back(points[i] + Vec3::Constant(1e-7));  // share their sets
  for (const Select select : {Select::nearest, Select::label}) {
    EvaluateOptions options{.model = {.kernel = Kernel::cubic, .neighbours = 30, .select = select},
                            .spacing = 0.006};
    const Evaluation one = by_threads(1, states, points, options),
                     two = by_threads(2, states, points, options);
    check_same(one, two);
    CHECK(one.made.reused > 0);
    CHECK(one.made.fitted + one.made.updated + one.made.reused == points.size());
    StateSpace space({.spacing = 0.006});
    for (const State& state : states) space.insert(state);
    for (std::size_t i = 0; i < points.size(); i += 7) {
      ModelUpdater alone(space, one.options.model);
      REQUIRE(one.made.forces[i] == alone.model_at(points[i]).force(points[i]));
      REQUIRE(one.made.labels[i] == space.label(points[i]));
    }
  }
}

TEST_CASE(
    "evaluate: no field is fitted where neither bars nor the choice use one, and bars do not depend on "
    "threads") {
  const std::vector<State> states = known_states(120);
  const std::vector<Vec3> points = scattered(140, 3);
  EvaluateOptions options{
      .choose = true, .model = {.kernel = Kernel::cubic, .neighbours = 20}, .spacing = 0.01};
  const Evaluation plain = evaluate(states, points, options);
  CHECK_FALSE(plain.field);
  CHECK(std::isfinite(plain.chosen->p95));
  options = {.bars = true, .spacing = 0.01};
  const Evaluation one = by_threads(1, states, points, options), two = by_threads(2, states, points, options);
  REQUIRE(one.field);
  check_same(one, two);
  options.field = one.field;  // the law of the same states, not sought again
  check_same(one, evaluate(states, points, options));
}
