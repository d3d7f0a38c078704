// The verdict of a study as a sentence, and its table of devices.

#include "scheduling/study/study_run.hpp"
#include "scheduling/study/study_verdict.hpp"
#include "small_body.hpp"

namespace {

// Three policies and the bound on four motions with four seeds; the value of each policy and a spread by seed.
Study policies() {
  return {.seeds = {1, 2, 3, 4},
          .axes = {{"policy", {{"nearest"}, {"coverage"}, {"fifo"}, {"clairvoyant"}}},
                   {"device", {{"path:press"}, {"path:circle"}, {"path:line"}, {"path:reach"}}}}};
}

Study with_motions(std::size_t count) {
  Study study = policies();
  study.axes[1].values.resize(count);
  return study;
}

std::vector<StudyCellResult> cells_with(const Study& study, const std::vector<double>& shares,
                                        double spread) {
  std::vector<StudyCellResult> cells;
  for (std::size_t i = 0; i < study.cells(); ++i) {
    const std::vector<std::size_t> choice = study.choice(study.combination_of(i));
    const double wiggle = spread * std::sin(12.9898 * static_cast<double>(i));
    cells.push_back(StudyCellResult({{"error.first_visit.within_jnd", shares[choice[0]] + wiggle}}));
  }
  return cells;
}

StudyPlan one_device(const DeviceSpec& device, double seconds) {
  return plan_study({.seeds = {1}, .axes = {{"policy", {{"nearest"}}}}}, [&](auto) {
    StudySession session{.input = small_input(Law::linear), .options = virtual_options(seconds)};
    session.options.motion.device = device;
    return session;
  });
}

}  // namespace

TEST_CASE("the verdict names the best policy, the next, their difference and whether it is significant") {
  const Study study = policies();
  const auto sure = study_verdict(study, cells_with(study, {0.6, 0.9, 0.5, 0.95}, 0.0002));
  REQUIRE(sure);
  CHECK_THAT(*sure,
             Catch::StartsWith(
                 "Best policy: coverage 90 %, nearest 60 %, fifo 50 % of first visits within the JND (") &&
                 Contains("30 points", "16 pairs on 4 motions", "the difference is significant",
                          "that to fifo is significant") &&
                 Catch::EndsWith("it knows the motion: clairvoyant."));
  const auto unsure = study_verdict(study, cells_with(study, {0.6, 0.601, 0.5, 0.95}, 0.05));
  REQUIRE(unsure);
  CHECK_THAT(*unsure, Catch::StartsWith("No winner: ") && Contains("95 % interval", "is not significant"));
  const auto equal = study_verdict(study, cells_with(study, {0.6, 0.6, 0.5, 0.95}, 0));
  REQUIRE(equal);
  CHECK_THAT(*equal, Catch::StartsWith("No winner: nearest 60 %, coverage 60 %") && Contains("equal in all"));
}

TEST_CASE("below four motions there is no winner and no interval, and it is said how many more settle it") {
  for (const std::size_t count : {1u, 2u, 3u}) {
    const Study study = with_motions(count);
    const auto cells = cells_with(study, {0.6, 0.65, 0.5, 0.95}, 0.01);
    const auto verdict = study_verdict(study, cells);
    REQUIRE(verdict);
    CHECK_THAT(*verdict, Catch::StartsWith("No winner: coverage ") && Contains("too few to compare") &&
                             !Contains("interval"));
    for (const Ranked& row : ranking_of(study, cells, 0, primary_metric(study)).ranked) {
      CHECK(std::isnan(row.value.student.low));
      CHECK(std::isnan(row.to_best.bootstrap.high));
      CHECK(row.tied);
    }
    for (const Contrast& c : contrasts(study, cells, primary_metric(study)))
      CHECK((c.comparison.verdict() == 0 && std::isnan(c.comparison.student.low)));
  }
  const Study two = with_motions(2);
  CHECK_THAT(
      *study_verdict(two, cells_with(two, {0.6, 0.65, 0.5, 0.95}, 0.05)),
      Contains("2 motions are too few to compare; about ", " more would settle a difference of ", " points"));
  const Study one = with_motions(1);
  CHECK_THAT(*study_verdict(one, cells_with(one, {0.6, 0.65, 0.5, 0.95}, 0.01)),
             Contains("1 motion is too few to compare; 4 is the least"));
}

TEST_CASE("table, contrasts and verdict have one order: the best first, a bound last") {
  const Study study = policies();
  const auto cells = cells_with(study, {0.6, 0.7, 0.65, 0.95}, 0.0002);
  const std::vector<std::size_t> order{1, 2, 0, 3};
  CHECK(ranked_levels(study, cells, 0) == order);
  const LevelRanking ranking = ranking_of(study, cells, 0, primary_metric(study));
  for (std::size_t i = 0; i < order.size(); ++i) CHECK(ranking.ranked[i].level == order[i]);
  CHECK(ranking.ranked[3].to_best.student.mean ==
        Approx(0.25).margin(0.001));  // against the best real policy
  std::vector<std::size_t> compared;
  for (const Contrast& c : contrasts(study, cells, primary_metric(study))) compared.push_back(c.a);
  CHECK(compared == std::vector<std::size_t>{2, 0, 3});  // each against the first
  CHECK_THAT(*study_verdict(study, cells),
             Catch::StartsWith("Best policy: coverage 70 %, fifo 65 %, nearest 60 % "));
}

TEST_CASE("there is no verdict where nothing competes") {
  const Study study{.seeds = {1}, .axes = {{"policy", {{"nearest"}}}}};
  CHECK_FALSE(study_verdict(study, cells_with(study, {0.2}, 0)));
}

TEST_CASE("a session of a study ends with its trace, and an endless motion after the study's seconds") {
  const TemporaryFolder folder;
  std::ofstream(folder / "short.csv") << "t,x,y,z\n0,0,0,0\n0.1,0,0,-0.002\n0.2,0,0.002,-0.003\n";
  const DeviceSpec trace = TraceMotion{.file = folder / "short.csv"};
  const StudyPlan ends = one_device(trace, 0.5), cut = one_device(trace, 0.05),
                  endless = one_device(PathMotion{.path = PathName::line}, 0.5);
  CHECK(ends.cells[0].options.clock.seconds == Approx(0.201));
  CHECK(cut.cells[0].options.clock.seconds == Approx(0.05));
  CHECK(endless.cells[0].options.clock.seconds == 0.5);

  const StudyResult result = run_study(ends, {.threads = 1});
  CHECK(result.cells[0].number("frames") == 201);
  CHECK(result.cells[0].number("motion_seconds") == Approx(0.2));
  const std::vector<StudyDevice> devices = study_devices(ends, result.cells);
  REQUIRE(devices.size() == 1);
  CHECK(devices[0].device == to_text(trace));
  CHECK(devices[0].motion_seconds == Approx(0.2));
  CHECK(devices[0].seconds == Approx(0.201));
  const StudyResult other = run_study(endless, {.threads = 1});
  CHECK(other.cells[0].number("frames") == 500);
  CHECK(std::isnan(other.cells[0].number("motion_seconds")));
  CHECK(std::isinf(study_devices(endless, other.cells)[0].motion_seconds));
}

TEST_CASE("devices show energy, clamping, saturation and time outside, and what stands out is said first") {
  StudyPlan plan = one_device(PathMotion{.path = PathName::line}, 0.1);
  const std::vector<StudyCellResult> cells{StudyCellResult({{"seconds", 0.1},
                                                            {"error.first_visit.samples", std::uint64_t{7}},
                                                            {"error.first_visit.within_jnd", 1.0},
                                                            {"safety.clamped_share", 0.31},
                                                            {"safety.slewed_share", 0.01},
                                                            {"time_outside", 0.38},
                                                            {"solver.busy_share", 0.9},
                                                            {"energy.generated_J", 0.002}})};
  const std::vector<StudyDevice> devices = study_devices(plan, cells);
  REQUIRE(devices.size() == 1);
  const StudyDevice& d = devices[0];
  CHECK(d.first_visits == 7);
  CHECK(d.clamped == 0.31);
  CHECK(d.slewed == 0.01);
  CHECK(d.outside == 0.38);
  CHECK(d.busy == 0.9);
  CHECK(d.generated == 0.002);
  const std::vector<std::string> lines = attention(devices);
  REQUIRE(lines.size() == 3);
  CHECK_THAT(lines[0], Contains("31 %", "clamped"));
  CHECK_THAT(lines[1], Contains("38 %", "outside the box"));
  CHECK_THAT(lines[2], Contains("7 first visits"));
}

TEST_CASE("unstable sessions of a study are said before everything else") {
  StudyPlan plan = one_device(PathMotion{.path = PathName::line}, 0.1);
  plan.cells.push_back(plan.cells[0]);
  const auto cell = [](bool stable) {
    return StudyCellResult({{"error.first_visit.samples", std::uint64_t{500}},
                            {"safety.clamped_share", 0.31},
                            {"stability.stable", stable}});
  };
  const std::vector<std::string> lines = attention(study_devices(plan, {cell(true), cell(false)}));
  REQUIRE(lines.size() == 2);
  CHECK_THAT(lines[0], Contains("1 of 2 sessions were unstable"));
  CHECK(attention(study_devices(plan, {cell(true), cell(true)})).size() == 1);
}

TEST_CASE("the columns that came later stand behind all others of a cell") {
  const StudyPlan plan = one_device(PathMotion{.path = PathName::line}, 0.1);
  const StudyResult result = run_study(plan, {.threads = 1});
  const auto place = [&](const std::string& name) {
    const auto& columns = result.cells[0].columns();
    const auto found = std::ranges::find(columns, name, &Column::name);
    REQUIRE(found != columns.end());
    return found - columns.begin();
  };
  for (const char* later :
       {"safety.clamped_share", "time_outside", "states.inverted", "solver.busy_share", "motion_seconds"})
    for (const char* older : {"memory_locked", "cost", "solver.wasted"}) CHECK(place(later) > place(older));
}

TEST_CASE(
    "motions needed: as many as give Student's interval a chance of 80 % to exclude zero, none without a "
    "spread") {
  Comparison d{
      .student = {.mean = 0.01, .low = -0.02, .high = 0.04}, .bootstrap = {}, .pairs = 6, .groups = 3};
  const auto needed = motions_needed(d);
  REQUIRE(needed);
  CHECK(*needed > 3);
  // The same by hand: half-width t_2 s / sqrt(3) = 0.03.
  const double spread = 0.03 * std::sqrt(3.0) / student_quantile(0.975, 2);
  const auto enough = [&](std::size_t n) {
    const auto freedom = static_cast<double>(n - 1);
    return 0.01 >= (student_quantile(0.975, freedom) + student_quantile(0.8, freedom)) * spread /
                       std::sqrt(static_cast<double>(n));
  };
  CHECK(enough(*needed));
  CHECK_FALSE(enough(*needed - 1));
  d.groups = 1;
  CHECK_FALSE(motions_needed(d));
  d = {.student = {.mean = 0, .low = -0.1, .high = 0.1}, .bootstrap = {}, .pairs = 6, .groups = 3};
  CHECK_FALSE(motions_needed(d));
}

TEST_CASE(
    "advice: more motions where a difference is not shown, a harder study at the ceiling, none where it is "
    "shown") {
  const Study study = policies();
  const auto all_lines = [&](const std::vector<double>& shares, double spread) {
    std::string text;
    for (const std::string& line : study_advice(study, cells_with(study, shares, spread)))
      text += line + "\n";
    return text;
  };
  CHECK(all_lines({0.6, 0.9, 0.5, 0.95}, 0.0002).empty());
  CHECK_THAT(all_lines({0.6, 0.61, 0.5, 0.95}, 0.05), Contains("more motions"));
  CHECK_THAT(all_lines({0.995, 0.995, 0.99, 0.999}, 0), Catch::StartsWith("Ceiling reached: every policy"));
  CHECK_THAT(all_lines({0.2, 0.3, 0.1, 0.4}, 0.0001), Catch::StartsWith("All are poor"));
}
