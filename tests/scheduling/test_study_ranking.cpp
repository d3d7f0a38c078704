// Evaluation of studies on synthetic results: rankings, contrasts, the search for a sustained speed.

#include "scheduling/study/study_ranking.hpp"
#include "scheduling/study/sustained_speed.hpp"
#include "tests/support/test.hpp"

namespace {

// Cells whose value for each metric is a formula.
std::vector<StudyCellResult> made_up(
    const Study& study, const std::function<double(const std::vector<std::size_t>&, std::uint64_t)>& f) {
  std::vector<StudyCellResult> cells;
  for (std::size_t c = 0; c < study.combinations(); ++c)
    for (const std::uint64_t seed : study.seeds) {
      const double value = f(study.choice(c), seed);
      cells.push_back(StudyCellResult({{"error.first_visit.within_jnd", value},
                                       {"error.within_jnd", 0.5},
                                       {"error.first_visit.p95", std::exp(-value)}}));
    }
  return cells;
}

}  // namespace

TEST_CASE("the highest sustained speed is found within 5 %") {
  const SustainedOptions options{.low = 0.01, .high = 2.0};
  for (const double truth : {0.0123, 0.05, 0.31, 1.3}) {
    double cost = 0;  // of all trials, over that of one at the speed found: slow runs are long
    const SustainedSpeed found = sustained_speed(options, [&](double v) {
      cost += 1 / v;
      return v <= truth ? 0.96 : 0.90;
    });
    CHECK(cost * found.speed < 8);
    CHECK(found.speed <= truth);
    CHECK(found.speed > truth / 1.06);
    CHECK_FALSE(found.capped);
    CHECK(found.trials < 20);
  }
  const SustainedSpeed all = sustained_speed(options, [](double) { return 1.0; });
  CHECK(all.speed == 2.0);
  CHECK(all.capped);
  CHECK(sustained_speed(options, [](double) { return 0.0; }).speed == 0);
  // A single failure below the limit does not end the search.
  CHECK(sustained_speed(options, [](double v) {
          return v > 0.035 && v < 0.045 ? 0.5 : v <= 0.5 ? 1.0 : 0.0;
        }).speed > 0.45);
}

TEST_CASE("rankings average settings within a trace and seed, and pair") {
  const Study study{.seeds = {1, 2, 3},
                    .axes = {{"policy", {{"nearest"}, {"coverage"}, {"fifo"}}},
                             {"device", {{"path:press"}, {"path:circle"}, {"path:line"}, {"path:reach"}}},
                             {"model.neighbours", {{"10"}, {"20"}}}},
                    .baseline = 0};
  // Traces differ widely, coverage gains 0.1 with 10 neighbours and 0.02 with 20; fifo is the same as nearest
  // but for noise.
  const auto cells = made_up(study, [](const std::vector<std::size_t>& c, std::uint64_t seed) {
    const double trace = 0.2 * static_cast<double>(c[1]),
                 noise = 0.001 * std::sin(10.0 * static_cast<double>(seed + 7 * c[1] + 31 * c[0]));
    return trace + noise + (c[0] == 1 ? (c[2] == 0 ? 0.1 : 0.02) : 0.0);
  });
  const std::vector<AxisRanking> ranked = rankings(study, cells);
  REQUIRE(ranked.size() == 2);  // policy and neighbours; motions are not compared with each other
  CHECK(ranked[0].ranking.blocks == 12);
  CHECK(ranked[0].ranking.ranked.front().level == 1);
  CHECK(ranked[0].ranking.ranked[2].to_best.student.mean == Approx(-0.06).margin(0.003));
  const std::vector<Contrast> compared = contrasts(study, cells, primary_metric(study));
  REQUIRE(compared.size() == 6);  // two policies: everywhere, and at either number of neighbours
  CHECK(compared[0].comparison.verdict() == 1);
  CHECK(compared[0].comparison.student.mean == Approx(0.06).margin(0.003));
  CHECK(compared[1].comparison.verdict() == 0);
  CHECK(compared[2].comparison.student.mean == Approx(0.1).margin(0.003));
  CHECK(compared[4].comparison.student.mean == Approx(0.02).margin(0.003));
  CHECK(compared[4].comparison.groups == 4);
  // coverage has the smaller error.
  const std::vector<Contrast> errors = contrasts(study, cells, second_metric(study));
  CHECK(errors[0].comparison.student.mean == Approx(-0.06).margin(0.003));
  CHECK(errors[0].comparison.verdict() == -1);
  CHECK(errors[0].comparison.lost == errors[0].comparison.pairs);
}

TEST_CASE("contrasts are adjusted by Holm over the values compared at one place, as the verdict is") {
  // On six traces the effects of b to e lie near the limit: each alone is significant, not all of them together.
  const std::vector<double> noise{0.9, -1.1, 0.4, 1.3, -0.7, 0.2};
  const auto cells_of = [&](const Study& study) {
    return made_up(study, [&](const std::vector<std::size_t>& c, std::uint64_t) {
      const double effect = c[0] == 0 ? 0 : c[0] == 1 ? 0.03 : 0.0115;
      return 0.4 + effect + (c[0] == 0 ? 0 : 0.01 * noise[(c[1] + 2 * c[0]) % 6]);
    });
  };
  const StudyAxis traces{"device", {{"1"}, {"2"}, {"3"}, {"4"}, {"5"}, {"6"}}};
  const Study study{
      .seeds = {1},
      .axes = {{"policy", {{"a"}, {"b"}, {"c"}, {"d"}, {"e"}}}, traces, {"speed", {{"1"}, {"2"}}}},
      .baseline = 0};
  const std::vector<Contrast> compared = contrasts(study, cells_of(study), primary_metric(study));
  REQUIRE(compared.size() == 12);  // four values: everywhere, and at either speed
  for (std::size_t family = 0; family < 3; ++family) {
    std::vector<double> p_values;
    for (std::size_t i = 0; i < 4; ++i) p_values.push_back(compared[4 * family + i].comparison.p_value());
    const std::vector<double> adjusted = holm(p_values);
    for (std::size_t i = 0; i < 4; ++i) CHECK(compared[4 * family + i].holm == adjusted[i]);
  }
  CHECK(compared[0].a == 1);
  CHECK(compared[0].verdict() == 1);
  CHECK(compared[1].comparison.verdict() == 1);
  CHECK(compared[1].comparison.p_value() < significant);
  CHECK(compared[1].holm > significant);
  CHECK(compared[1].verdict() == 0);
  // Of two values there is one comparison, and nothing to adjust.
  const Study two{.seeds = {1}, .axes = {{"policy", {{"a"}, {"b"}}}, traces}, .baseline = 0};
  const std::vector<Contrast> single = contrasts(two, cells_of(two), primary_metric(two));
  REQUIRE(single.size() == 1);
  CHECK(single[0].holm == single[0].comparison.p_value());
}

TEST_CASE("steps are each compared with the one before") {
  const Study study{.seeds = {1, 2, 3, 4}, .axes = {{"step", {{"a"}, {"b"}, {"c"}}}}};
  const auto cells = made_up(study, [](const std::vector<std::size_t>& c, std::uint64_t seed) {
    return 0.1 * static_cast<double>(c[0]) + 0.01 * static_cast<double>(seed % 2);
  });
  const std::vector<Contrast> compared = contrasts(study, cells, primary_metric(study));
  REQUIRE(compared.size() == 2);
  CHECK(compared[1].a == 2);
  CHECK(compared[1].b == 1);
  CHECK(compared[1].comparison.student.mean == Approx(0.1));
}
