// Notes of sessions are shortened by kind, and those of a study's cells reach its result.

#include "scheduling/record/notes.hpp"
#include "scheduling/study/study_run.hpp"
#include "small_body.hpp"

namespace {

using Lines = std::vector<std::string>;

struct Infinite final : Policy {
  std::string_view name() const override { return "infinite"; }
  double priority(const Candidate& candidate, const PlannerView&) const override {
    return candidate.order % 2 == 0 ? std::numeric_limits<double>::infinity() : 1;
  }
};

}  // namespace

TEST_CASE("more than three notes that differ only in numbers become one with their number") {
  const auto failed = [](int i) {
    return "solve at 0.00" + std::to_string(i) + ", -1e-05, +2 m failed: stalled";
  };
  const Lines few{failed(1), "mine", failed(2), failed(3)};
  CHECK(shortened_notes(few) == few);
  Lines many{"before"};
  for (int i = 0; i < 300; ++i) many.push_back(i % 2 == 0 ? failed(i) : "trace b.csv: ends");
  CHECK(shortened_notes(many) == Lines{"before", failed(0) + " (and 149 more lines like this)",
                                       "trace b.csv: ends (and 149 more lines like this)"});
  CHECK(shortened_notes(Lines{}).empty());
}

TEST_CASE("notes of several sessions are one line for each kind, with the number of sessions") {
  const std::vector<Lines> cells{{"a 1", "a 2"}, {}, {"b", "a 7"}, {"b"}};
  CHECK(notes_in_common(cells) == Lines{"2 of 4 cells: a 1 (and 2 more lines like this)",
                                        "2 of 4 cells: b (and 1 more line like this)"});
  CHECK(notes_in_common(std::vector<Lines>(3)).empty());
}

TEST_CASE("what a policy does against its contract is told by the study too") {
  const Study study{.seeds = {1, 2}, .axes = {{"policy", {{"nearest"}, {"mine"}}}}};
  const StudyPlan plan = plan_study(study, [](std::span<const std::size_t> choice) {
    StudySession session{.input = small_input(Law::linear), .options = virtual_options(0.2)};
    if (choice[0] == 1) session.input.parts.policy = std::make_shared<Infinite>();
    session.options.planning.policy = "nearest";
    return session;
  });
  const StudyResult result = run_study(plan, {.threads = 1});
  CHECK(result.cells[0].notes().size() + 1 == result.cells[2].notes().size());
  const Lines notes = notes_of(result.cells);
  REQUIRE(!notes.empty());
  CHECK_THAT(notes.back(), Catch::StartsWith("2 of 4 cells: policy infinite gave priorities"));
}

TEST_CASE("states that come after the last frame are said, with the number that the last frame knew") {
  SessionOptions options = virtual_options(0.3);
  options.clock.kind = Clock::real;
  options.workers = {};
  const SessionResult result = run_session(small_input(Law::neo_hookean), options);
  REQUIRE(!result.frames.empty());
  const std::size_t all = result.counts.start + result.counts.solved, seen = result.frames.back().known;
  Lines found;
  for (const std::string& note : result.notes)
    if (note.find("came after the last frame") != std::string::npos) found.push_back(note);
  INFO(all << " states, the last frame knew " << seen);
  CHECK(found.size() == (all > seen ? 1 : 0));
  if (all > seen)
    CHECK_THAT(found.front(), Catch::StartsWith(std::to_string(all - seen) + " of the ") &&
                                  Contains("which knew " + std::to_string(seen)));
}
