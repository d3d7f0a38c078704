// A hand that stays at one place and trembles gives hundreds of true rows about it. What they tell is welcome there,
// and changes nothing elsewhere.

#include <algorithm>
#include <array>
#include <random>
#include <span>

#include "approx/measured/force_field.hpp"
#include "approx/methods/evaluate.hpp"
#include "tests/approx/measured_cases.hpp"
#include "tests/support/test.hpp"

using namespace forefeel;
using namespace forefeel::test;

namespace {

constexpr double half = 0.02;  // of the extent [m]
constexpr std::size_t places = 60;

Vec3 stiffening(const Vec3& x) {
  return -Vec3(250, 250, 420).cwiseProduct(x) * (1 + 0.35 * x.squaredNorm() / (half * half));
}

// Some places, and then a dwell.
MeasuredCase dwell_of(unsigned seed, std::size_t rows, double tremor, double noise) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> even(-half, half);
  std::normal_distribution<double> normal;
  MeasuredCase given{.noise = noise};
  const auto vector = [&](auto& of) { return Vec3(of(random), of(random), of(random)); };
  for (std::size_t i = 0; i < places; ++i) given.at.push_back(vector(even));
  const Vec3 place = 0.5 * vector(even);
  for (std::size_t i = 0; i < rows; ++i) given.at.emplace_back(place + tremor * vector(normal));
  for (const Vec3& x : given.at) given.force.emplace_back(stiffening(x) + noise * vector(normal));
  for (int i = 0; i < 120; ++i) given.points.emplace_back(0.9 * vector(even));
  for (const Vec3& x : given.points) given.truth.push_back(stiffening(x));
  return given;
}

struct Found {
  double median = 0, p95 = 0, most = 0,
         held = 0;  // of the errors; share within 1.61 deviations and the least error
};

Found found_from(const MeasuredCase& given, std::size_t rows) {
  std::vector<State> states = given.states();
  states.resize(rows);
  StateSpace space({.spacing = 0.2 * half});
  for (const State& state : states) space.insert(state);
  const std::optional<FieldOptions> law = field_of(states);
  REQUIRE(law);
  const ForceField field(space, *law);
  std::vector<double> errors;
  double held = 0;
  for (std::size_t i = 0; i < given.points.size(); ++i) {
    const ForceField::Prediction made = field.at(given.points[i]);
    errors.push_back((made.force - given.truth[i]).norm());
    if (errors.back() <= 1.61 * made.deviation + 3 * made.least_error)
      held += 1 / double(given.points.size());
  }
  std::ranges::sort(errors);
  return {errors[errors.size() / 2], errors[errors.size() * 95 / 100], errors.back(), held};
}

}  // namespace

TEST_CASE("Rows of a dwell with any tremor spoil nothing elsewhere", "[measured]") {
  constexpr std::array tremors{0.0003, 0.0005, 0.0007, 0.001, 0.001, 0.0013, 0.0016, 0.002, 0.0025, 0.001};
  for (unsigned k = 0; k < tremors.size(); ++k) {
    const double noise = k % 3 == 2 ? 0.02 : 0;
    const MeasuredCase given = dwell_of(k, 200 + 50 * (k % 5), tremors[k], noise);
    const Found alone = found_from(given, places), with = found_from(given, given.at.size());

    INFO(k);
    CHECK(with.median <= 1.3 * alone.median);
    CHECK(with.p95 <= 2 * alone.p95);
    CHECK(with.most <= 2 * alone.most);
    CHECK(with.held >= 0.93);
  }
}

TEST_CASE("A dwell counts as few rows where a model is chosen: auto, its forces and its bars stay",
          "[measured]") {
  struct Draw {
    std::size_t rows;
    double tremor;
  };
  for (unsigned k = 0; const Draw draw : {Draw{600, 0.0008}, {700, 0.0012}, {1500, 0.0016}}) {
    const MeasuredCase given = dwell_of(++k, draw.rows, draw.tremor, 0);
    const auto errors_of = [&](std::size_t rows) {
      std::vector<State> states = given.states();
      states.resize(rows);
      const Evaluation made = evaluate(states, given.points, {.bars = true, .spacing = 0.5 * half});
      std::vector<double> errors, bars;
      double held = 0;
      for (std::size_t i = 0; i < given.points.size(); ++i) {
        errors.push_back((made.made.forces[i] - given.truth[i]).norm());
        bars.push_back(made.bars->at[i][1]);
        held += errors[i] <= bars[i] ? 1 / double(given.points.size()) : 0;
      }
      std::ranges::sort(errors);
      std::ranges::sort(bars);
      return std::array{errors[errors.size() * 95 / 100], bars[bars.size() / 2], held};
    };
    const auto alone = errors_of(places), with = errors_of(given.at.size());
    INFO(k);
    CHECK(with[0] <= 1.5 * alone[0]);
    CHECK(with[1] <= 2 * alone[1]);  // other rows are left out
    CHECK(with[2] >= 0.93);
  }
}

TEST_CASE("A row of a tracker that was lost changes no force and no bar elsewhere", "[measured]") {
  MeasuredCase given = dwell_of(3, 20, 0.005, 0);
  const auto made_of = [&](std::span<const Vec3> points) {
    return evaluate(given.states(), points, {.bars = true, .spacing = 0.5 * half});
  };
  const Evaluation alone = made_of(given.points);
  given.at.emplace_back(0.5, 0.3, 0.4);
  given.force.emplace_back(Vec3::Zero());
  const Evaluation with = made_of(given.points);
  for (std::size_t i = 0; i < given.points.size(); ++i) {
    CHECK(with.made.forces[i] == alone.made.forces[i]);
    CHECK(with.bars->at[i] == alone.bars->at[i]);
  }
  const Vec3 beside = given.at.back() + Vec3(0.001, 0, 0);  // asked about: it stays
  const Evaluation kept = made_of(std::span(&beside, 1));
  CHECK(kept.states == given.at.size());
  // What is left out is said.
  CHECK(with.far_row_left_out);
  CHECK_FALSE(alone.far_row_left_out);
  CHECK_FALSE(kept.far_row_left_out);
}
