// Measured forces that once misled: a line with noise in its positions, a curve, a raster of dense lines, rows given
// twice. Each with ten variants.

#include "approx/measured/force_field.hpp"
#include "geometry/common/quantiles.hpp"
#include "tests/approx/measured_cases.hpp"
#include "tests/support/test.hpp"

namespace {

// 100 places along x, f = (-100 x, 0, 0); points on it and beside it. jitter: noise of the positions [m].
MeasuredCase line(const Variant& v, double jitter) {
  MeasuredCase made{.noise = 0.01 * v.noise};
  std::mt19937 random(v.seed);
  std::normal_distribution<double> normal;
  const auto shake = [&](double by) {
    return Vec3(by * Vec3(normal(random), normal(random), normal(random)));
  };
  for (int i = 0; i < 100; ++i) {
    const Vec3 at(-0.01 + 0.02 * i / 99, 0, 0);
    made.at.push_back(at + shake(jitter));
    made.force.push_back(Vec3(-100 * at.x(), 0, 0) + shake(made.noise));
  }
  for (const double x : {-0.005, 0.0, 0.005})
    for (const double beside : {0.0, 2e-4, 1e-3, 3e-3}) {
      made.points.emplace_back(x, beside, 0);
      made.truth.emplace_back(-100 * x, 0, 0);
    }
  apply(v, made);
  return made;
}

// 80 places on a winding curve on a sphere of 3 cm, and points up to 1 mm beside it in any direction.
MeasuredCase curve(const Variant& v) {
  MeasuredCase made{.noise = 0.002 * v.noise};
  std::mt19937 random(v.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto drawn = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  const auto place = [](double t) {
    const double polar = 0.5 * std::sin(2 * 3.14159 * t), around = 2.5 * (t - 0.5);
    return Vec3(
        0.03 * Vec3(std::sin(around) * std::cos(polar), std::sin(polar), std::cos(around) * std::cos(polar)) -
        Vec3(0, 0, 0.02));
  };
  const auto force = [](const Vec3& x) {
    return Vec3(-40 * x.x(), -40 * x.y() * (1 + 10 * x.x()), 2 * std::exp(-60 * x.z()));
  };
  for (int i = 0; i < 80; ++i) {
    const Vec3 at = place(i / 79.0);
    made.at.push_back(at + 1e-5 * drawn());
    made.force.push_back(force(at) + made.noise * drawn());
  }
  for (int i = 0; i < 100; ++i) {
    const double away = 5e-5 * std::pow(20, uniform(random));
    made.points.push_back(place(0.05 + 0.9 * uniform(random)) + away * drawn().normalized());
    made.truth.push_back(force(made.points.back()));
  }
  apply(v, made);
  return made;
}

// 21 lines along x, 3 mm apart in 3 depths, 15 places each; |f| is about 3 N. Points between the lines.
Vec3 raster_force(const Vec3& x) {
  return {-320 * x.x() * (1 + 20 * x.z()), -320 * x.y() + 0.3 * std::sin(300 * x.x()),
          1 + 200 * std::abs(x.z()) * (1 - 800 * x.x() * x.x())};
}
MeasuredCase raster(const Variant& v) {
  MeasuredCase made{.noise = 0.05 * v.noise};
  std::mt19937 random(v.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto shake = [&](double by) {
    return Vec3(by * Vec3(normal(random), normal(random), normal(random)));
  };
  for (int depth = 0; depth < 3; ++depth)
    for (int across = -3; across <= 3; ++across)
      for (int i = 0; i < 15; ++i) {
        const Vec3 at = Vec3(-0.01 + 0.02 * i / 14, 0.003 * across, -0.002 - 0.002 * depth) + shake(5e-6);
        made.at.push_back(at);
        made.force.push_back(raster_force(at) + shake(made.noise));
      }
  for (int i = 0; i < 100; ++i) {
    made.points.emplace_back(0.0095 * uniform(random), 0.0088 * uniform(random),
                             -0.004 + 0.0019 * uniform(random));
    made.truth.push_back(raster_force(made.points.back()));
  }
  apply(v, made);
  return made;
}

// 80 random places of a curved field.
MeasuredCase scattered(const Variant& v) {
  MeasuredCase made;
  std::mt19937 random(v.seed);
  std::uniform_real_distribution<double> uniform(-0.01, 0.01);
  const auto force = [](const Vec3& x) {
    return Vec3(std::sin(400 * x.x()), 100 * x.z() * std::cos(500 * x.y()), -std::exp(120 * x.z()));
  };
  for (int i = 0; i < 160; ++i) {
    const Vec3 at(uniform(random), uniform(random), 0.5 * uniform(random) - 0.005);
    (i < 80 ? made.at : made.points).push_back(at);
    (i < 80 ? made.force : made.truth).push_back(force(at));
  }
  apply(v, made);
  return made;
}

// Two presses 2 cm apart, held at five depths each, with noise in the positions. Points between them.
MeasuredCase held_presses(const Variant& v) {
  MeasuredCase made{.noise = 0.02 * v.noise};
  std::mt19937 random(v.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto drawn = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  const auto force = [](const Vec3& x) {
    return Vec3(-40 * x.x(), -40 * x.y() * (1 + 10 * x.x()), 2 * std::exp(-60 * x.z()));
  };
  const auto place = [](double side, int depth) { return Vec3(0.01 * side, 0.004, -0.002 * (depth + 1)); };
  for (const double side : {-1.0, 1.0})
    for (int depth = 0; depth < 5; ++depth)
      for (int row = 0; row < 10; ++row) {
        made.at.push_back(place(side, depth) + 2e-5 * drawn());
        made.force.push_back(force(place(side, depth)) + made.noise * drawn());
      }
  for (int i = 0; i < 100; ++i) {
    const double away = uniform(random);
    made.points.push_back((1 - away) * place(-1, i % 5) + away * place(1, i % 5));
    made.truth.push_back(force(made.points.back()));
  }
  apply(v, made);
  return made;
}

}  // namespace

// The forces of the two presses differ by less than the error allowed here. Slopes across a press, from its noise, and
// feet on a parabola through two presses gave twice the largest force.
TEST_CASE("Between two presses that were held the force is between theirs", "[measured]") {
  for (const Variant& v : ten_variants()) {
    const MeasuredCase given = held_presses(v);
    const Evaluation found =
        evaluate(given.states(), given.points, {.bars = true, .spacing = 0.002 * v.length});
    const std::vector<double> errors = errors_of(found, given);
    CAPTURE(v.seed, given.largest(), quantile_of(errors, 0.95));
    CHECK(quantile_of(errors, 0.95) < 0.1 * given.largest());
    CHECK(held(found, errors) >= 0.93);
  }
}

TEST_CASE("Noise in the positions of a line changes nothing; beside it the bar grows with the distance",
          "[measured]") {
  for (const Variant& v : ten_variants())
    for (const double jitter : {0.0, 1e-7}) {
      if (jitter == 0 && v.seed > 1) continue;
      const MeasuredCase given = line(v, jitter);
      const Evaluation found =
          evaluate(given.states(), given.points, {.bars = true, .spacing = 0.003 * v.length});
      const std::vector<double> errors = errors_of(found, given);
      for (std::size_t i = 0; i < errors.size(); ++i) {
        CAPTURE(v.seed, jitter, i, given.noise, errors[i], found.bars->at[i][1]);
        CHECK(errors[i] <
              0.6 * given.noise);  // a line through 100 forces: 3 deviations of 3 components at 0.1
        if (i % 4 == 0) continue;
        const double away = std::array{0.0, 2e-4, 1e-3, 3e-3}[i % 4];
        CHECK(found.bars->at[i][1] >= 0.9 * 100 * v.newtons * away);
        CHECK(found.bars->at[i][1] > found.bars->at[i - 1][1]);
      }
      CHECK(std::abs(found.field->law.noise / given.noise - 1) < 0.2);
    }
}

TEST_CASE("Beside a curve, which bends, the bars hold as beside a line", "[measured]") {
  for (const Variant& v : ten_variants()) {
    const MeasuredCase given = curve(v);
    const Evaluation found =
        evaluate(given.states(), given.points, {.bars = true, .spacing = 0.003 * v.length});
    CAPTURE(v.seed);
    CHECK(held(found, errors_of(found, given)) >= 0.93);
  }
}

TEST_CASE("Between the dense lines of a raster the error is that of a smooth field, as expected",
          "[measured]" SLOW("fits fields of hundreds of rows for every group left out")) {
  for (const Variant& v : ten_variants()) {
    const MeasuredCase given = raster(v);
    const Evaluation found =
        evaluate(given.states(), given.points, {.bars = v.seed < 3, .spacing = 0.004 * v.length});
    const std::vector<double> errors = errors_of(found, given);
    const double p95 = quantile_of(errors, 0.95);
    REQUIRE(found.chosen);
    CAPTURE(v.seed, given.noise, p95, found.chosen->p95);
    CHECK(p95 < given.noise);  // SciPy's linear kernel with 50 neighbours: 2.7 times the noise of 0.05 N
    CHECK(found.chosen->p95 > 2 * given.noise);  // of comparisons with measured forces: chi, 3 degrees, 2.8
    CHECK(found.chosen->p95 < 4 * given.noise);
    CHECK(found.chosen->groups >= 7);
    CHECK(found.chosen->groups < 210);  // lines, not rows
    if (found.bars) CHECK(held(found, errors) > 0.85);
  }
}

// 35 lines of 40 rows at five depths, 4 mm apart: a mean of two depths would be off by 0.07 N.
TEST_CASE("A mean of rows is of rows of one line",
          "[measured]" SLOW("fits fields of hundreds of rows for every group left out")) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const auto force = [](const Vec3& x) {
    return Vec3(-80 * x[0], -80 * x[1], -300 * x[2] * (1 - 60 * x[2]));
  };
  MeasuredCase given;
  for (int line = 0; line < 35; ++line)
    for (int i = 0; i < 40; ++i) {
      given.at.emplace_back(-0.012 + 0.024 * i / 39, 0.004 * (line % 7 - 3), 0.004 * (line / 7 - 2));
      given.force.push_back(force(given.at.back()) +
                            0.02 * Vec3(normal(random), normal(random), normal(random)));
      if (i % 8 == 0) given.points.push_back(0.9 * given.at.back() + Vec3(3e-4, 1e-3, -1e-3));
    }
  for (const Vec3& x : given.points) given.truth.push_back(force(x));
  const MeasuredRows boxes = averaged_boxes(given.states(), 2);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    CAPTURE(i);
    CHECK(std::abs(std::remainder(boxes.at[i][2], 0.004)) < 1e-12);
    CHECK(std::abs(std::remainder(boxes.at[i][1], 0.004)) < 1e-12);
  }
  const Evaluation found = evaluate(given.states(), given.points, {});
  CHECK(quantile_of(errors_of(found, given), 0.95) < 0.01);  // 0.022 with means of two depths
}

TEST_CASE("Rows are averaged where the field is flat among them, not where they are far apart",
          "[measured]" SLOW("fits fields of hundreds of rows for every group left out")) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-0.01, 0.01);
  std::vector<Vec3> far, dense, far_force, dense_force;
  const auto force = [](const Vec3& x) {
    return Vec3(std::sin(300 * x.x()), std::cos(250 * x.y()), 100 * x.z());
  };
  const auto noise = [&] { return Vec3(0.01 * Vec3(normal(random), normal(random), normal(random))); };
  for (int i = 0; i < 1400; ++i) {
    far.emplace_back(uniform(random), uniform(random), uniform(random));
    dense.emplace_back(-0.01 + 0.02 * i / 1399, 0, 0);
    far_force.push_back(force(far.back()) + 0.2 * noise());
    dense_force.push_back(force(dense.back()) + noise());
  }
  const std::optional<FieldOptions> apart = field_of(measured_states(far, far_force));
  const std::optional<FieldOptions> near = field_of(measured_states(dense, dense_force));
  REQUIRE(apart);
  REQUIRE(near);
  CHECK(apart->neighbours > 0);
  CHECK(near->neighbours == 0);
  CHECK(near->box == 2);
  CHECK(std::abs(apart->law.noise / 0.002 - 1) < 0.2);
  CHECK(std::abs(near->law.noise / 0.01 - 1) < 0.2);
}

// Against processes of the remaining rows alone.
TEST_CASE("Laws are compared by rows that were left out",
          "[measured]" SLOW("fits fields of hundreds of rows for every group left out")) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(-0.01, 0.01);
  const FieldLaw law{.smoothness = Smoothness::matern52, .length = 0.007, .amplitude = 0.8, .noise = 0.05};
  MeasuredRows rows;
  Grouping groups;
  for (std::uint32_t i = 0; i < 24; ++i) {
    rows.add(Vec3(uniform(random), uniform(random), uniform(random)),
             Vec3(100 * uniform(random), 100 * uniform(random), 100 * uniform(random)), i % 3 + 1);
    groups.push_back(i % 8);
  }
  std::vector<double> missed(8, 0), spread(8, 0);
  double mean = 0;
  for (std::uint32_t g = 0; g < 8; ++g) {
    MeasuredRows others;
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (groups[i] != g) others.add(rows.at[i], rows.force[i], rows.weight[i]);
    const GaussianProcess process(others, law);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (groups[i] != g) continue;
      const GaussianProcess::Prediction made = process.at(rows.at[i]);
      const double v = made.deviation * made.deviation + law.noise * law.noise / rows.weight[i];
      missed[g] += (made.force - rows.force[i]).squaredNorm() / v / 3;  // three rows of each group
      spread[g] += std::log(v) / 3;
      mean += (made.force - rows.force[i]).squaredNorm() / v / 24;
    }
  }
  const auto scores = left_out_scores(rows, law, std::array{groups});
  REQUIRE(scores.size() == 1);
  for (std::size_t g = 0; g < 8; ++g)
    CHECK(scores[0][g] == Approx(0.5 * missed[g] / (mean / 3) + 1.5 * (std::log(mean / 3) + spread[g])));
}

// A stiff wall in a linear field: a Gaussian law with noise is the likeliest of all rows. It smooths the kink by a
// multiple of the noise and is sure of it.
TEST_CASE("A force with a kink is followed by a law of each place",
          "[measured]" SLOW("fits fields of hundreds of rows for every group left out")) {
  MeasuredCase made;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-0.02, 0.02);
  const auto force = [](const Vec3& x) {
    return Vec3(-20 * x.x(), 30 * x.y(), 300 * std::max(0.0, -x.z() - 0.004 * std::sin(100 * x.x())));
  };
  const auto place = [&] { return Vec3(uniform(random), uniform(random), 0.5 * uniform(random) - 0.01); };
  for (int i = 0; i < 800; ++i) {
    made.at.push_back(place());
    made.force.push_back(force(made.at.back()) +
                         0.003 * Vec3(normal(random), normal(random), normal(random)));
  }
  for (int i = 0; i < 100; ++i) {
    made.points.push_back(place());
    made.truth.push_back(force(made.points.back()));
  }
  const Evaluation found = evaluate(made.states(), made.points, {.bars = true, .spacing = 0.005});
  REQUIRE(found.chosen->field);
  CHECK(found.chosen->field->local);
  const std::vector<double> errors = errors_of(found, made);
  CHECK(held(found, errors) >= 0.93);
  MeasuredRows some, all;
  for (std::size_t i = 0; i < made.at.size(); ++i) {
    if (i < 250) some.add(made.at[i], made.force[i]);
    all.add(made.at[i], made.force[i]);
  }
  const GaussianProcess smooth(all, likely_law(some, Smoothness::gaussian)->law);
  std::vector<double> smoothed;
  for (std::size_t i = 0; i < made.points.size(); ++i)
    smoothed.push_back((smooth.force(made.points[i]) - made.truth[i]).norm());
  CAPTURE(quantile_of(errors, 0.95), quantile_of(smoothed, 0.95));
  CHECK(quantile_of(errors, 0.95) < 0.8 * quantile_of(smoothed, 0.95));
}

// A model of so many rows would take 1.4 GB. The process averages neighbouring ones.
TEST_CASE("A long stroke is judged as a short one is",
          "[measured]" SLOW("fits fields of thousands of rows")) {
  MeasuredCase made;
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 9000; ++i) {
    made.at.emplace_back(-0.01 + 0.02 * i / 8999, 0, 0);
    made.force.push_back(Vec3(-100 * made.at.back().x(), 0, 0) +
                         0.01 * Vec3(normal(random), normal(random), normal(random)));
  }
  for (const double x : {-0.008, -0.001, 0.006}) {
    made.points.emplace_back(x, 0, 0);
    made.truth.emplace_back(-100 * x, 0, 0);
  }
  const Evaluation found = evaluate(made.states(), made.points, {.spacing = 0.002});
  REQUIRE(found.chosen->field);
  for (const double error : errors_of(found, made)) CHECK(error < 0.002);  // a fifth of the noise of one row
}

// A cubic on three levels: no row tells of the third degree across them, and the likeliest law is very long.
TEST_CASE("Between the few levels of a lattice the bars hold", "[measured]") {
  for (const Variant& v : ten_variants()) {
    MeasuredCase made;
    std::mt19937 random(v.seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(-0.02, 0.02);
    const auto force = [](const Vec3& x) { return Vec3(-60 * x * (1 + 1500 * x.squaredNorm())); };
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        for (int k = 0; k < 3; ++k) {
          made.at.emplace_back(-0.02 + 0.008 * i, -0.02 + 0.008 * j, -0.02 + 0.01 * k);
          made.force.push_back(force(made.at.back()) +
                               0.0015 * v.noise * Vec3(normal(random), normal(random), normal(random)));
        }
    for (int i = 0; i < 100; ++i) {
      made.points.emplace_back(uniform(random), uniform(random), 0.5 * uniform(random) - 0.01);
      made.truth.push_back(force(made.points.back()));
    }
    apply(v, made);
    const Evaluation found = evaluate(made.states(), made.points, {.bars = true, .spacing = 0.01 * v.length});
    CAPTURE(v.seed);
    CHECK(held(found, errors_of(found, made)) >= 0.93);
  }
}

TEST_CASE("A row given twice counts once",
          "[measured]" SLOW("fits fields of hundreds of rows for every group left out")) {
  for (const Variant& v : ten_variants()) {
    const MeasuredCase given = scattered(v);
    std::vector<State> once = given.states(), twice = once;
    twice.insert(twice.end(), once.begin(), once.begin() + (v.seed % 2 == 0 ? 80 : 30));
    if (v.seed % 3 == 0) twice.insert(twice.end(), once.begin() + 40, once.end());
    const EvaluateOptions options{.bars = true, .spacing = 0.005 * v.length};
    const Evaluation a = evaluate(once, given.points, options), b = evaluate(twice, given.points, options);
    CHECK(a.states == b.states);
    CHECK(a.chosen->p95 == b.chosen->p95);
    CHECK(a.chosen->groups == b.chosen->groups);
    for (std::size_t i = 0; i < given.points.size(); ++i) {
      CHECK(a.made.forces[i] == b.made.forces[i]);
      CHECK(a.bars->at[i] == b.bars->at[i]);
    }
    CAPTURE(v.seed);
    CHECK(held(a, errors_of(a, given)) > 0.85);
  }
}
