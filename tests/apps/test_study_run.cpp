// Studies in a folder: the cells depend neither on the number of threads nor on interruptions.

#include <sys/file.h>

#include "apps/study/study_folder.hpp"
#include "apps/study/study_report.hpp"
#include "apps/study/study_table.hpp"
#include "tests/apps/study_fixture.hpp"

namespace {

std::vector<StudyCellResult> run(const StudyPlan& plan, const fs::path& folder, int threads,
                                 std::size_t* ran = nullptr) {
  Globals globals;
  globals.quiet = true;
  globals.threads = threads;
  StudyResult result = run_study_in({folder}, {}, plan, globals);
  if (ran) *ran = result.ran;
  add_regret(plan.study, result.cells);
  return result.cells;
}

}  // namespace

TEST_CASE("a target load is met by a hand too, whose motion answers the force") {
  const StudyFixture folder;
  const PlannedStudy planned = plan_study(
      read_study(folder.study("seeds = [1, 2]\n[material]\nlaw = \"linear\"\nyoung = "
                              "20000.0\n[session]\nseconds = 6.0\ndevice = \"hand:touch,target=circle\"\n"
                              "[vary]\ntarget_load = [0.5, 1.0]\n"),
                 {}));
  const StudyPlan& plan = planned.plan;
  std::vector<StudyCellResult> cells = run(plan, folder.path / "out", 2);
  REQUIRE(cells.size() == 4);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    CHECK(cells[i].number("load") == Approx(i < 2 ? 0.5 : 1.0).epsilon(0.05));
    CHECK(
        *cells[i].find("cost") !=
        ColumnValue(to_text(plan.cells[i].options.workers.cost)));  // that of a hand which nothing holds back
  }
  CHECK_FALSE(loads_missed(plan, cells));
  cells[3].set("load", 1.2);
  REQUIRE(loads_missed(plan, cells));
  CHECK_THAT(*loads_missed(plan, cells), Catch::StartsWith("1 of 4 cells") && Contains("20 %"));
}

TEST_CASE("a target load is the load that the session measures") {
  const StudyFixture folder;
  const PlannedStudy planned = plan_study(read_study(
      folder.study(
          "seeds = [3]\n[session]\nseconds = 1.0\nrest_known = true\n[vary]\n"
          "\"session.latency\" = [0.0, 0.001]\n\"session.batch\" = [1, 3]\ntarget_load = [0.5, 2.0]\n"),
      {}));
  const StudyPlan& plan = planned.plan;
  REQUIRE(plan.cells.size() == 8);
  for (std::size_t i = 0; i < 8; ++i) {
    StudyCell cell = plan.cells[i];
    CHECK(std::holds_alternative<LogNormalCost>(cell.options.workers.cost.cost()));
    // A fixed cost of the same mean: the measured load is then exactly the wanted one.
    const double demand = states_needed_per_second(plan.inputs[i], cell.options),
                 target = i % 2 == 0 ? 0.5 : 2.0;
    const double b = cell.options.planning.batch, share = cell.options.workers.batch_share;
    if (b > 1 && i % 2 == 1) continue;  // so few jobs that the last, cut short, counts
    const double job = target * cell.options.workers.count * b / demand - 2 * cell.options.workers.latency;
    cell.options.workers.cost = ConstantCost{job / (1 + (b - 1) * share)};
    const SessionInput& input = plan.inputs[i];
    const StudyCellResult row = cell_result(run_session(input, cell.options), input, cell.options);
    CHECK(row.number("load") == Approx(target).epsilon(b > 1 ? 0.05 : 0.01));  // a batch may be cut short
  }
}

TEST_CASE("cells.csv has the same bytes for 1 and 2 threads, after a break, and only missing cells are run") {
  const StudyFixture folder;
  const std::string varied =
      "[vary]\npolicy = [\"nearest\", \"clairvoyant\"]\ncost = [\"constant:0.02\", \"paper\"]\n";
  const PlannedStudy planned = plan_study(read_study(folder.study("seeds = [1, 2]\n" + varied), {}));
  const StudyPlan& plan = planned.plan;
  std::size_t ran = 0;
  const std::vector<StudyCellResult> first = run(plan, folder.path / "one", 1, &ran);
  CHECK(ran == 8);
  const std::string table = cells_csv(plan.study, first);
  CHECK(cells_csv(plan.study, run(plan, folder.path / "two", 2)) == table);

  run(plan, folder.path / "one", 2, &ran);
  CHECK(ran == 0);
  // One record is missing, one is cut in the middle (a killed run never leaves that), and one is foreign.
  const auto record = [&](std::size_t i) {
    return folder.path / "one" / "cells" / (plan.cells[i].key + ".json");
  };
  fs::remove(record(0));
  std::ifstream in(record(3));
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  std::ofstream(record(3)) << text.substr(0, text.size() / 2);
  std::ofstream(record(5)) << "{\"key\": \"other\", \"columns\": {}}";
  const std::vector<StudyCellResult> again = run(plan, folder.path / "one", 2, &ran);
  CHECK(ran == 3);
  CHECK(cells_csv(plan.study, again) == table);

  const StudyPlan wider = plan_study(read_study(folder.study("seeds = [2, 3]\n" + varied), {})).plan;
  run(wider, folder.path / "one", 1, &ran);
  CHECK(ran == 4);

  // A header, then as many values as names in every row; nothing of the wall clock.
  std::istringstream lines(table);
  std::string header;
  std::getline(lines, header);
  CHECK(header.starts_with("policy,cost,seed,clock,seconds,frames,"));
  CHECK_THAT(header, Contains("error.first_visit.within_jnd"));
  CHECK_THAT(header, !Contains(",policy"));
  CHECK_THAT(header, !Contains("provenance"));
  for (const StudyCellResult& cell : first) {
    REQUIRE(cell.find("wall_seconds"));
    CHECK(std::holds_alternative<std::monostate>(*cell.find("wall_seconds")));
  }
  // Regret is the difference to the clairvoyant rows.
  CHECK(first[4].number("regret.first_visit.within_jnd") == 0);
  CHECK(first[0].number("regret.within_jnd") ==
        Approx(first[4].number("error.within_jnd") - first[0].number("error.within_jnd")));
}

TEST_CASE("a second writer to the same folder is refused") {
  const StudyFixture folder;
  const PlannedStudy planned = plan_study(read_study(folder.study("seeds = [1]\n"), {}));
  const StudyPlan& plan = planned.plan;
  run(plan, folder.path / "out", 1);
  // The lock belongs to this open file, not to the process.
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> holder(
      std::fopen((folder.path / "out/cells/lock").c_str(), "r"), std::fclose);
  REQUIRE(holder);
  REQUIRE(flock(fileno(holder.get()), LOCK_EX | LOCK_NB) == 0);
  CHECK_THAT(error_of([&] { run(plan, folder.path / "out", 1); }), Contains("another study"));
}

TEST_CASE("text with commas and quotes survives in cells.csv") {
  const Study study{.seeds = {1}, .axes = {{"device", {{"path:press,speed=0.06"}}}}};
  const StudyCellResult cell({{"a", std::string("say \"so\", twice")}, {"b", {}}, {"c", 0.1}});
  CHECK(cells_csv(study, {cell}) ==
        "device,seed,a,b,c\n\"path:press,speed=0.06\",1,\"say \"\"so\"\", twice\",,0.1\n");
}

TEST_CASE("sustained speeds: the report says what counts where not even the lowest holds") {
  const StudyFixture folder;
  const PlannedStudy planned =
      plan_study(read_study(folder.study("seeds = [1, 2]\n[session]\ndevice = \"path:press\"\n[vary]\npolicy "
                                         "= [\"nearest\", \"fifo\"]\n[sustained]\nlow = 0.02\n"),
                            {}));
  const StudyPlan& plan = planned.plan;
  StudyResult result;
  for (const double speed : {0.0, 0.08, 0.16, 0.16}) {
    result.cells.push_back(StudyCellResult({{"sustained.speed", speed}}));
  }
  const auto page = [&] {
    return study_page(planned, result, rankings(plan.study, result.cells),
                      contrasts(plan.study, result.cells, primary_metric(plan.study)), {});
  };
  const std::vector<std::string> notes = sustained_notes(plan.study, result.cells);
  REQUIRE(notes.size() == 2);
  CHECK_THAT(notes[0], Contains("at its own sustained speed"));
  CHECK_THAT(notes[1], Contains("In 1 of 4 cells", "20 mm/s", "lower bounds"));
  for (const std::string& note : notes) CHECK_THAT(page(), Contains(note));
  // It counts as the lowest: seed 1 is 0.16 over 0.02, seed 2 0.16 over 0.08.
  const std::vector<Contrast> compared = contrasts(plan.study, result.cells, primary_metric(plan.study));
  REQUIRE_FALSE(compared.empty());
  CHECK(std::abs(compared[0].comparison.student.mean) == Approx(0.5 * (std::log(8) + std::log(2))));
  result.cells[0].set("sustained.speed", 0.02);
  CHECK(sustained_notes(plan.study, result.cells).size() == 1);
  CHECK_THAT(page(), !Contains("not even the lowest"));
  CHECK(sustained_notes(Study{}, result.cells).empty());
}

TEST_CASE("the document says who has won by the metric, of which less may be better") {
  const Study study{
      .seeds = {1},
      .axes = {{"policy", {{"nearest"}, {"coverage"}}}, {"device", {{"a"}, {"b"}, {"c"}, {"d"}}}},
      .baseline = 0};
  std::vector<StudyCellResult> cells;
  for (std::size_t i = 0; i < study.cells(); ++i) {
    const double share = i < 4 ? 0.5 : 0.6, error = std::exp(-share) + 0.001 * static_cast<double>(i % 4);
    cells.push_back(
        StudyCellResult({{"error.first_visit.within_jnd", share + 0.001 * static_cast<double>(i % 4 * i % 3)},
                         {"error.first_visit.p95", error}}));
  }
  for (const StudyMetric& metric : {primary_metric(study), second_metric(study)}) {
    CAPTURE(metric.key);
    const auto told = ranking_json(study, {}, contrasts(study, cells, metric))["contrasts"][0];
    CHECK(told["value"] == "coverage");
    CHECK(told["won"] == told["pairs"]);
    CHECK(told["lost"] == 0);
    CHECK(told["verdict"] == 1);
  }
}
