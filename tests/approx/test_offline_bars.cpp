// Error bars without a session: measured against the true field, which the bars never see, and the choice of
// spacing and of places known within a tolerance.

#include "approx/error/error_bar.hpp"
#include "approx/methods/evaluate.hpp"
#include "geometry/common/quantiles.hpp"
#include "tests/support/test.hpp"

namespace {

using Field = std::function<Vec3(const Vec3&)>;

// A stiffening force with its exact stiffness, curved more on one side.
Vec3 stiffening(const Vec3& x) {
  return -40 * x * (1 + 900 * x.squaredNorm()) -
         Vec3(0.2 * std::sin(180 * x.y()), 0, 0.3 * x.x() * x.z() / 0.01);
}

struct Known {
  std::vector<State> states;
  std::vector<Vec3> points;
};

// Places drawn over a box of 6 cm, and points drawn in it. noise: of each force component [N].
Known drawn(unsigned seed, int states, int points, double noise, const Field& field) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> side(-0.03, 0.03);
  std::normal_distribution<double> sensor(0, 1);
  const auto place = [&] { return Vec3(side(random), side(random), side(random)); };
  Known known;
  for (int i = 0; i < states; ++i) {
    State state;
    state.at = place();
    state.force = field(state.at) + noise * Vec3(sensor(random), sensor(random), sensor(random));
    known.states.push_back(state);
  }
  for (int i = 0; i < points; ++i) known.points.push_back(place());
  return known;
}

// A force that stiffens with the distance, and is smooth over 12 mm.
Vec3 smooth_stiffening(const Vec3& x) {
  return -40 * x * (1 + 900 * x.squaredNorm()) - Vec3(0, 0, 0.3 * x.x() * x.z() / 0.01);
}

// Share of the points whose bar holds what `truth` says there, for each level.
std::array<double, 3> inside(const Known& known, const Evaluation& found, const Field& truth) {
  std::array<double, 3> shares{};
  for (std::size_t i = 0; i < known.points.size(); ++i) {
    const double error = (found.made.forces[i] - truth(known.points[i])).norm();
    for (std::size_t level = 0; level < 3; ++level)
      shares[level] += error <= found.bars->at[i][level] ? 1.0 / double(known.points.size()) : 0.0;
  }
  return shares;
}

}  // namespace

// A few states that are just enough leave no room to leave some out. Solves at other places judge them directly.
TEST_CASE("Bars from check solves hold the true force as often as they say, and are as narrow as the error") {
  const Box box{Vec3::Constant(-0.03), Vec3::Constant(0.03)};
  Known known;
  Evaluation checked;
  std::array<double, 3> mean{};
  constexpr unsigned draws = 12;
  for (unsigned seed = 0; seed < draws; ++seed) {
    known = drawn(50 + seed, 30, 400, 0, stiffening);
    const Known checks = drawn(70 + seed, 100, 0, 0, stiffening);
    checked = evaluate(known.states, known.points, {.bars = true, .checks = {checks.states, box}});
    REQUIRE(checked.bars->measured->checked());
    const std::array<double, 3> shares = inside(known, checked, stiffening);
    for (std::size_t level = 0; level < 3; ++level) mean[level] += shares[level] / draws;
  }
  CHECK_FALSE(evaluate(known.states, known.points, {.bars = true}).bars->measured->checked());
  INFO(mean[0] << " " << mean[1] << " " << mean[2]);
  // Three deviations of a mean over 12 draws of 100 checks and 400 places each.
  for (std::size_t level = 0; level < 3; ++level) {
    const double p = bar_levels[level];
    CHECK(std::abs(mean[level] - p) <
          3 * std::sqrt(p * (1 - p) * (1.0 / 100 + 1.0 / 400) / draws) + 1.0 / 100);
  }
  // The bar of 95 % is the tolerance that the checks hold: all of the box is known within it, nothing within less.
  std::vector<double> errors;
  for (std::size_t i = 0; i < known.points.size(); ++i)
    errors.push_back((checked.made.forces[i] - stiffening(known.points[i])).norm() /
                     std::max(checked.made.forces[i].norm(), 0.05));
  std::ranges::sort(errors);
  const double true_95 = errors[errors.size() * 95 / 100];
  const double bar = checked.bars->at[0][1] / std::max(checked.made.forces[0].norm(), 0.05);
  CHECK(bar > 0.6 * true_95);
  CHECK(bar < 1.7 * true_95);
  for (std::size_t i = 0; i < known.points.size(); ++i) {
    const double here = checked.bars->at[i][1], force = checked.made.forces[i].norm();
    CHECK(here <= Tolerance{.value = 1.01 * bar}.limit(force));
    CHECK(here > Tolerance{.value = 0.9 * bar}.limit(force));
  }
}

TEST_CASE("Bars of drawn places hold the true force about as often as they say",
          SLOW("judges bars at hundreds of places")) {
  std::array<double, 3> mean{};
  constexpr int sets = 6;
  for (unsigned seed = 0; seed < sets; ++seed) {
    const Known known = drawn(seed, 400, 300, 0, stiffening);
    const Evaluation found = evaluate(known.states, known.points,
                                      {.model = {.kernel = Kernel::cubic}, .bars = true, .spacing = 0.006});
    REQUIRE(found.bars);
    const BarCover cover = found.bars->measured->cover();
    CHECK(cover.samples > 380);  // 400, but for those outside the others
    const std::array<double, 3> shares = inside(known, found, stiffening);
    for (std::size_t level = 0; level < 3; ++level) {
      mean[level] += shares[level] / sets;
      CHECK(std::abs(cover.inside[level] - bar_levels[level]) < 0.03);  // left out: three deviations of 400
    }
  }
  INFO(mean[0] << " " << mean[1] << " " << mean[2]);
  for (std::size_t level = 0; level < 3; ++level) CHECK(std::abs(mean[level] - bar_levels[level]) < 0.03);
}

TEST_CASE("Bars grow with the noise of the known forces, also where states lie close") {
  const Known quiet = drawn(7, 300, 100, 0, stiffening), noisy = drawn(7, 300, 100, 0.2, stiffening);
  const EvaluateOptions options{.choose = true, .bars = true, .spacing = 0.006};
  const Evaluation a = evaluate(quiet.states, quiet.points, options),
                   b = evaluate(noisy.states, noisy.points, options);
  // A single component has the deviation 0.2 N: |noise| exceeds 0.2 sqrt(7.81) N at 5 % (chi squared, 3 degrees).
  const double usual = b.bars->measured->cover().width_p50;
  CHECK(usual > 0.2 * std::sqrt(7.81));
  CHECK(usual < 4 * 0.2 * std::sqrt(7.81));
  for (std::size_t i = 0; i < 100; ++i) CHECK(b.bars->at[i][1] > a.bars->at[i][1] * 0.5);
  // Where the noise is the same, no bar inside is over 20 times another. The middle of the box is inside.
  for (const Evaluation& found : {a, b})
    for (std::size_t level = 0; level < 3; ++level) {
      double least = 1e9, widest = 0;
      for (std::size_t i = 0; i < 100; ++i) {
        least = std::min(least, found.bars->at[i][level]);
        if (quiet.points[i].cwiseAbs().maxCoeff() < 0.02) widest = std::max(widest, found.bars->at[i][level]);
      }
      CHECK(widest <= 20.001 * least);
    }
}

TEST_CASE("A level without enough forces left out has no bar") {
  const Known known = drawn(3, 40, 5, 0, stiffening);
  const Evaluation found = evaluate(known.states, known.points,
                                    {.model = {.kernel = Kernel::cubic}, .bars = true, .spacing = 0.01});
  REQUIRE(found.bars);
  CHECK(std::isfinite(found.bars->at[0][1]));  // 95 % needs 19
  CHECK(std::isinf(found.bars->at[0][2]));     // 99 % needs 99
  const Known few = drawn(3, 7, 5, 0, stiffening);
  const Evaluation none =
      evaluate(few.states, few.points, {.model = {.kernel = Kernel::cubic}, .bars = true, .spacing = 0.01});
  CHECK(std::isinf(none.bars->at[0][0]));
  CHECK(std::isnan(none.bars->measured->cover().inside[0]));
}

TEST_CASE("A point farther away than any force left out is counted") {
  Known known = drawn(5, 200, 3, 0, stiffening);
  known.points.push_back(Vec3(0.5, 0, 0));
  const Evaluation found = evaluate(known.states, known.points,
                                    {.model = {.kernel = Kernel::cubic}, .bars = true, .spacing = 0.006});
  CHECK(found.bars->beyond == 1);
}

TEST_CASE("Bars one layer outside a lattice are those of extrapolation") {
  constexpr double h = 0.012;
  for (const Vec3& out : {Vec3(1, 0, 0), Vec3(0, 0, -1), Vec3(0, -1, 0)}) {
    CAPTURE(out.transpose());
    Known known;
    std::vector<Vec3> inner;
    for (int x = -2; x <= 2; ++x)
      for (int y = -2; y <= 2; ++y)
        for (int z = -2; z <= 2; ++z) {
          const Vec3 at = h * Vec3(x, y, z);
          State state;
          state.at = at;
          state.force = smooth_stiffening(at);
          if (out.dot(at) > 1.5 * h) {
            known.points.push_back(at);
          } else {
            known.states.push_back(state);
            if (at.cwiseAbs().maxCoeff() < 1.5 * h) inner.push_back(at + Vec3(0.2, 0.3, 0.1) * h);
          }
        }
    const EvaluateOptions options{.choose = true, .bars = true, .spacing = h};
    const Evaluation found = evaluate(known.states, known.points, options);
    REQUIRE(found.bars);
    const std::array<double, 3> shares = inside(known, found, smooth_stiffening);
    CAPTURE(shares[0], shares[1], shares[2]);
    CHECK(found.bars->measured->cover_outside().samples >= known.points.size());
    CHECK(shares[1] > 0.8);
    std::vector<double> errors;
    for (std::size_t i = 0; i < known.points.size(); ++i)
      errors.push_back((found.made.forces[i] - smooth_stiffening(known.points[i])).norm());
    const double p95 = quantile_of(errors, 0.95);
    CAPTURE(p95, found.chosen->p95);
    CHECK(found.chosen->p95 > 0.4 * p95);
    // Points between the states keep the narrow bars of interpolation.
    const Evaluation between = evaluate(known.states, inner, options);
    CHECK(between.bars->at[0][1] < 0.5 * found.bars->at[0][1]);
  }
}

TEST_CASE("The suggested spacing is the spread up to which 95 % lie within the tolerance") {
  // 200 forces of 1 N: the error is below 0.07 N up to a spread of 5 mm, above it beyond.
  std::vector<BarSample> samples(200);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].spread = 1e-4 * double(i + 1);
    samples[i].force = samples[i].predicted = 1;
    samples[i].error = samples[i].spread <= 0.005 ? 0.01 : 0.2;
    samples[i].bar = {samples[i].spread, 2 * samples[i].spread, 1};
  }
  const SpacingAdvice advice = advise_spacing(samples, {.value = 0.07}, 0.95);
  // 50 within; 52 of them keep 50 / 52 >= 0.95, 53 do not.
  CHECK(advice.safe == 52);
  CHECK(advice.within == 50);
  CHECK(advice.spacing == Approx(0.0052 / 0.95));
  CHECK(!advice.all);
  CHECK(advice.wider_within == 0);
  CHECK(std::isnan(advise_spacing(samples, {.value = 0.005}, 0.95).spacing));
  CHECK(advise_spacing(samples, {.value = 0.3, .newtons = true}, 0.95).all);
  const KnownWithin known = known_within(samples, {.value = 0.016, .newtons = true});
  CHECK(known.called == 80);  // 2 spread <= 0.016
  CHECK(known.true_ones == 50);
}

TEST_CASE("Tolerances are read as a share or as newtons") {
  CHECK(tolerance_from("0.07")->limit(2) == Approx(0.14));
  CHECK(tolerance_from("0.07")->limit(0.001) == Approx(0.07 * 0.05));
  CHECK(tolerance_from("0.07 N")->limit(2) == Approx(0.07));
  CHECK(tolerance_from("0.07N")->newtons);
  for (const char* wrong : {"", "N", "0", "-1 N", "0.07 kg", "7 %", "nan", "1e999 N"})
    CHECK(!tolerance_from(wrong));
}

// A smooth law takes a rough part of the force for noise. Held-out forces then miss by more there than elsewhere.
TEST_CASE("bars of measured states are wide where held-out forces miss by more than noise",
          "[offline_bars]") {
  constexpr double noise = 0.01, scale = 0.005, misfit = 0.04;  // misfit, noise: of a component
  double inside = 0, count = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> side(-0.01, 0.01);
    const auto error = [&](double x, double sensor, double rough) {
      const double more = x > 0 ? rough : 0;
      const double deviation = std::sqrt(sensor * sensor + scale * scale / 3 + more * more);
      return (deviation * Vec3(normal(random), normal(random), normal(random))).norm();
    };
    const auto bars_of = [&](double rough) {
      std::vector<BarSample> samples;
      for (std::uint32_t i = 0; i < 400; ++i) {
        BarSample s;
        s.at = Vec3(side(random), side(random), side(random));
        s.scale = scale;
        s.error = error(s.at.x(), noise, rough);
        s.part = i % 8;
        samples.push_back(s);
      }
      // The law's own noise: what it cannot follow, on average.
      return OfflineBars(std::move(samples),
                         {.noise = std::hypot(noise, rough * std::sqrt(0.5)), .groups = 100});
    };
    const OfflineBars rough = bars_of(misfit), even = bars_of(0);
    for (int i = 0; i < 300; ++i) {
      const Vec3 x(side(random), side(random), side(random));
      const double bar = rough.at({.x = x, .scale = scale})[1];
      CHECK(even.at({.x = x, .scale = scale})[1] < 1.5 * 1.61 * scale);
      CHECK(even.at({.x = x, .scale = scale})[1] > 0.99 * 1.61 * scale);
      if (std::abs(x.x()) < 0.006) continue;      // neighbours on both sides
      if (x.x() < 0) CHECK(bar < 1.61 * misfit);  // less than half as wide as beside it
      if (x.x() > 0) inside += error(x.x(), 0, misfit) <= bar, ++count;
    }
  }
  CHECK(inside / count > 0.9);
  CHECK(inside / count < 0.99);
}

// A tenth of the errors is four times as large as the process says, at random: no place tells which.
TEST_CASE("bars of measured states have the tails of the held-out errors", "[offline_bars]") {
  double inside = 0, count = 0, plain = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> side(-0.01, 0.01);
    const auto place = [&] { return Vec3(side(random), side(random), side(random)); };
    constexpr double scale = 0.01;
    const auto error = [&] {
      const double more = side(random) > 0.008 ? 4 : 1;
      return (more * scale / std::sqrt(3.0) * Vec3(normal(random), normal(random), normal(random))).norm();
    };
    std::vector<BarSample> samples;
    double squared = 0;
    for (std::uint32_t i = 0; i < 400; ++i) {
      samples.push_back({.at = place(), .scale = scale, .error = error(), .part = i % 8});
      squared += samples.back().error * samples.back().error / 400;
    }
    const OfflineBars bars(std::move(samples), {.groups = 400});
    for (int i = 0; i < 1000; ++i) {
      const Vec3 x = place();
      const double e = error();
      inside += e <= bars.at({.x = x, .scale = scale})[1], ++count;
      plain += e <= 1.61 * std::sqrt(squared);  // normal errors of the same root mean square
    }
  }
  CHECK(std::abs(inside / count - 0.95) < 0.015);
  CHECK(plain / count < 0.935);
}
