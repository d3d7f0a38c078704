// Error bars: the calibration against scores of a known distribution, the scale against fields whose error is
// known.

#include "approx/error/error_bar.hpp"
#include "approx/error/error_scale.hpp"
#include "tests/support/test.hpp"

namespace {

// Share of `count` scores inside each level, scores |N(0, deviation)| with the deviation by step.
template <class Deviation>
std::array<double, 3> coverage(ConformalFactors& factors, std::mt19937_64& random, int first, int count,
                               Deviation deviation) {
  std::normal_distribution<double> normal;
  std::array<int, 3> inside{};
  for (int i = first; i < first + count; ++i) {
    const double score = std::abs(normal(random)) * deviation(i);
    for (std::size_t level = 0; level < 3; ++level)
      inside[level] += score <= factors.factors(Label::sparse)[level];
    factors.learn(Label::sparse, score);
  }
  std::array<double, 3> shares{};
  for (std::size_t level = 0; level < 3; ++level) shares[level] = static_cast<double>(inside[level]) / count;
  return shares;
}

}  // namespace

TEST_CASE("Scores that do not change: the factors are the quantiles of their distribution") {
  ConformalFactors factors({.gamma = 0, .window = 4000});
  std::mt19937_64 random(1);
  coverage(factors, random, 0, 4000, [](int) { return 3.0; });
  // Quantiles of |N(0, 3)|: 3 times those of the half-normal distribution.
  const std::array<double, 3> oracle{3 * 1.6449, 3 * 1.9600, 3 * 2.5758};
  for (std::size_t level = 0; level < 3; ++level)  // 6 %: three standard errors at 99 %, of 4000 scores
    CHECK(factors.factors(Label::sparse)[level] == Approx(oracle[level]).epsilon(0.06));
  CHECK(std::isinf(factors.factors(Label::safe)[0]));  // labels are independent
}

TEST_CASE("Scores that drift by a factor of twenty stay within two points of every level") {
  ConformalFactors factors;
  std::mt19937_64 random(2);
  const auto drifting = [](int i) { return 0.3 * std::pow(20.0, 0.5 - 0.5 * std::cos(i * 1e-3)); };
  const std::array<double, 3> shares = coverage(factors, random, 0, 12000, drifting);
  for (std::size_t level = 0; level < 3; ++level) CHECK(std::abs(shares[level] - bar_levels[level]) < 0.02);
}

TEST_CASE("Scores that grow fivefold at once are within five points again after 200") {
  ConformalFactors factors;
  std::mt19937_64 random(3);
  const auto step = [](int i) { return i < 2000 ? 0.5 : 2.5; };
  coverage(factors, random, 0, 2000, step);
  const double before = factors.factors(Label::sparse)[1];
  coverage(factors, random, 2000, 200, step);
  CHECK(factors.factors(Label::sparse)[1] > 3 * before);
  const std::array<double, 3> after = coverage(factors, random, 2200, 2000, step);
  for (std::size_t level = 0; level < 3; ++level) CHECK(std::abs(after[level] - bar_levels[level]) < 0.05);
}

TEST_CASE("A prior holds until there are scores, and its weight is that of so many") {
  std::array<PriorScores, 4> prior{};
  for (PriorScores& one : prior)  // scores uniform in [0, 10]
    for (std::size_t i = 0; i < one.size(); ++i) one[i] = 10 * prior_shares[i];
  ConformalFactors factors({.gamma = 0, .prior_weight = 100, .prior = prior});
  CHECK(factors.factors(Label::safe)[0] == Approx(9.0));
  CHECK(factors.factors(Label::safe)[1] == Approx(9.5));
  CHECK(factors.factors(Label::safe)[2] == Approx(9.9));
  for (int i = 0; i < 100; ++i) factors.learn(Label::safe, 20);  // half of all now: above the median
  for (std::size_t level = 0; level < 3; ++level) CHECK(factors.factors(Label::safe)[level] == 20);
  for (int i = 0; i < 200; ++i) factors.learn(Label::blank, 0.5);  // 90 % of 300 is at 70 % of the prior
  CHECK(factors.factors(Label::blank)[0] == Approx(7.0));
}

TEST_CASE("Wider levels are never narrower, and what is no number teaches nothing") {
  ConformalFactors factors;
  factors.learn(Label::gap, 1);
  const auto before = factors.factors(Label::gap);
  factors.learn(Label::gap, std::nan(""));
  factors.learn(Label::gap, INFINITY);
  CHECK(factors.factors(Label::gap) == before);
  std::mt19937_64 random(4);
  std::lognormal_distribution<double> heavy(0, 2);
  for (int i = 0; i < 500; ++i) {
    factors.learn(Label::gap, heavy(random), i % 3 == 0 ? 1 : 0.2);
    const auto& now = factors.factors(Label::gap);
    REQUIRE(now[0] <= now[1]);
    REQUIRE(now[1] <= now[2]);
  }
}

TEST_CASE("The scale of a field f = -k x - c |x|^2 e is its departure from the nearest tangent") {
  const double k = 200, c = 5e4, h = 0.006;
  const Vec3 e(0, 0, 1);
  const auto state = [&](const Vec3& x) {
    State s;
    s.at = x;
    s.force = -k * x - c * x.squaredNorm() * e;
    s.stiffness = k * Mat3::Identity() + 2 * c * e * x.transpose();  // K = -df/dx
    return s;
  };
  std::vector<State> states;
  for (int i = -1; i <= 1; ++i)
    for (int j = 0; j <= 1; ++j)
      for (int l = 0; l <= 1; ++l) states.push_back(state(h * Vec3(i, j, l)));
  const ErrorScale scale(states, h);
  const Vec3 x(0.001, 0.0005, -0.0007);  // nearest: rest
  const double departure = c * x.squaredNorm();
  // ||f - t|| + 1/2 c d^2 + 0.01 c h^2, exact for this field: every pair of states departs by c d^2.
  const double expected = 1.5 * departure + 0.01 * c * h * h;
  CHECK(scale.at(x, state(x).force) == Approx(expected).epsilon(1e-3));
  CHECK(scale.at(x, state(x).force + Vec3(0.5, 0, 0)) > 0.4);  // a model that disagrees
  CHECK(std::isinf(ErrorScale().at(x, Vec3::Zero())));
  CHECK(std::isinf(ErrorScale({}, h).at(x, Vec3::Zero())));
}

TEST_CASE(
    "The level of a body is the mean of its scores beside the prior's five; a change is forgotten by a "
    "hundred") {
  BodyLevel level;
  CHECK(level.stretch() == Approx(1));
  for (int i = 0; i < 95; ++i) level.learn(2.0);
  CHECK(level.stretch() == Approx(std::exp(2 * 0.95 * (std::log(2.0) + 1.85))));
  const double before = level.stretch();
  for (int i = 0; i < 100; ++i) level.learn(10.0);  // errors five times as large: (1 - 0.99^100) of the way
  const double way = 1 - std::pow(0.99, 100), from = std::log(before) / 2 - 1.85;
  CHECK(level.stretch() == Approx(std::exp(2 * (from + way * (std::log(10.0) - from) + 1.85))));
  const double after = level.stretch();
  for (const double none : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    level.learn(none);
  CHECK(level.stretch() == after);
}

TEST_CASE("A stretched scale is so many times the scale") {
  State a, b;
  b.at = Vec3(0.01, 0, 0);
  a.force = Vec3::Zero();
  b.force = Vec3(1, 0, 0);
  const std::array states{a, b};
  ErrorScale scale(states, 0.01);
  const Vec3 x(0.004, 0.001, 0), f(0.3, 0, 0);
  const double before = scale.at(x, f);
  REQUIRE(std::isfinite(before));
  scale.stretch(7);
  CHECK(scale.at(x, f) == Approx(7 * before));
  CHECK(scale.stretched() == 7);
}
