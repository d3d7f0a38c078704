// Studies in code: cells made from typed sessions, run in memory, the same for any number of threads.

#include <mutex>

#include "scheduling/study/study_run.hpp"
#include "small_body.hpp"

namespace {

const Study two_policies{.seeds = {1, 2}, .axes = {{"policy", {{"nearest"}, {"coverage"}}}}};

StudyPlan small_plan(const Study& study) {
  return plan_study(study, [](std::span<const std::size_t> choice) {
    StudySession session{.input = small_input(Law::linear), .options = virtual_options(0.2)};
    session.options.planning.policy = choice[0] == 0 ? "nearest" : "coverage";
    return session;
  });
}

bool same(const std::vector<Column>& a, const std::vector<Column>& b) {
  return std::ranges::equal(
      a, b, [](const Column& x, const Column& y) { return x.name == y.name && x.value == y.value; });
}

std::string refusal(const Study& study, const SessionOptions& options) {
  try {
    plan_study(study, [&](auto) { return StudySession{small_input(Law::linear), options}; });
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a study in code: a row a cell, the same with one thread and three") {
  const StudyPlan plan = small_plan(two_policies);
  REQUIRE(plan.cells.size() == 4);
  CHECK(plan.cells[1].options.seed == 2);
  CHECK(plan.cells[2].options.planning.policy.name == "coverage");
  const StudyResult one = run_study(plan, {.threads = 1}), three = run_study(plan, {.threads = 3});
  CHECK(one.ran == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    CAPTURE(i);
    CHECK(one.cells[i].number("frames") == 200);
    CHECK(one.cells[i].number("solver.busy") > 0);
    CHECK(std::get<std::string>(*one.cells[i].find("policy")) == plan.cells[i].options.planning.policy.name);
    CHECK(same(one.cells[i].columns(), three.cells[i].columns()));
  }
}

TEST_CASE("a store is asked first and told at once") {
  const StudyPlan plan = small_plan(two_policies);
  std::mutex mutex;
  std::map<std::uint64_t, StudyCellResult> kept;  // by seed, of policy nearest
  const StudyStore store{.load = [&](const StudyCell& cell) -> std::optional<StudyCellResult> {
                           const auto found = kept.find(cell.seed);
                           if (cell.choice[0] != 0 || found == kept.end()) return {};
                           return found->second;
                         },
                         .save =
                             [&](const StudyCell& cell, const StudyCellResult& row) {
                               const std::lock_guard lock(mutex);
                               if (cell.choice[0] == 0) kept[cell.seed] = row;
                             }};
  const StudyResult first = run_study(plan, {.threads = 2, .store = store});
  CHECK(kept.size() == 2);
  double share = 0;
  const StudyResult again = run_study(
      plan, {.threads = 2, .store = store, .progress = [&](const StudyProgress& p) { share = p.share; }});
  CHECK(again.ran == 2);
  CHECK(again.resumed == 2);
  CHECK(share == Approx(1));
  for (std::size_t i = 0; i < 4; ++i) CHECK(same(first.cells[i].columns(), again.cells[i].columns()));
}

TEST_CASE("a cell whose session fails does not cost the others theirs") {
  struct Breaking final : Policy {
    std::string_view name() const override { return "breaking"; }
    double priority(const Candidate&, const PlannerView&) const override {
      throw std::runtime_error("it broke");
    }
  };
  const StudyPlan plan = plan_study(two_policies, [](std::span<const std::size_t> choice) {
    StudySession session{.input = small_input(Law::linear), .options = virtual_options(0.2)};
    if (choice[0] == 0) session.input.parts.policy = std::make_shared<Breaking>();
    return session;
  });
  std::mutex mutex;
  std::size_t kept = 0;
  const auto save = [&](const StudyCell& cell, const StudyCellResult&) {
    const std::lock_guard lock(mutex);
    CHECK(cell.choice[0] == 1);
    ++kept;
  };
  std::string problem;
  try {
    run_study(plan, {.threads = 2, .store = {.save = save}});
  } catch (const StudyFailure& failure) {
    problem = failure.what();
  }
  CHECK(kept == 2);
  CHECK_THAT(problem, Catch::StartsWith("2 of 4 cells failed, the first with policy breaking and seed 1: ") &&
                          Contains("it broke"));
}

TEST_CASE("an interrupted study leaves its cells empty") {
  const std::atomic<bool> stop{true};
  const StudyResult result = run_study(small_plan(two_policies), {.threads = 1, .interrupted = &stop});
  CHECK(result.interrupted);
  CHECK(result.ran == 0);
  for (const StudyCellResult& cell : result.cells) CHECK(cell.empty());
}

TEST_CASE("what a cell cannot run with is refused when the study is planned") {
  SessionOptions options = virtual_options(0.2);
  Study study{.seeds = {1}, .axes = {{"speed", {{"0.1", 0.1}}}}};
  options.motion.device = PathMotion{.speed = 0.1};
  CHECK_THAT(refusal(study, options), Catch::StartsWith("study.speed: ") && Contains("speed already"));
  study = {.seeds = {1}, .axes = {{"target_load", {{"1", 1.0}}}}};
  options.workers.latency = 10;
  CHECK_THAT(refusal(study, options),
             Catch::StartsWith("study.target_load: ") && Contains("message of 10 s"));
  study = {.seeds = {1}, .axes = {}, .sustained = SustainedOptions{}};
  options.motion.device = HandMotion{};
  CHECK_THAT(refusal(study, options), Catch::StartsWith("study.sustained: ") && Contains("no speed"));
  options = virtual_options(0.2);
  options.workers.count = 0;
  CHECK_THAT(refusal({.seeds = {1}, .axes = {}}, options), Contains("workers"));
}
