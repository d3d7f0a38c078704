// Limiting cases of sessions: not begun, more neighbours than states, no room for a lattice cell.

#include <sqlite3.h>

#include "run_logs.hpp"
#include "scheduling/record/summary.hpp"
#include "scheduling/session/session.hpp"
#include "small_body.hpp"

TEST_CASE("an interrupted rehearsal leaves a session that was not begun") {
  const TemporaryFolder folder;
  std::atomic<bool> stop{true};
  SessionOptions options = virtual_options(2);
  options.planning.policy = "clairvoyant";
  options.stop.interrupted = &stop;
  SessionInput input = small_input();
  input.files.states = folder / "session.states";
  State rest;
  rest.at = rest.force = Vec3::Zero();
  rest.solve.status = SolveStatus::converged;
  input.known = {rest};
  std::size_t delivered = 0, positions = 0;
  const SessionResult result =
      run_session(input, options,
                  {.when_run = [&](const SessionResult& so_far) { delivered += 1 + so_far.frames.size(); },
                   .each_position = [&](const Vec3&) { ++positions; }});
  CHECK(result.interrupted());
  CHECK(result.run.end == RunEnd::not_begun);
  CHECK(result.frames.empty());
  CHECK(result.dispatch.empty());
  CHECK(result.states.size() == 1);
  CHECK(result.counts.start == 1);
  CHECK(result.counts.solved == 0);
  CHECK(result.counts.failed == 0);
  CHECK(delivered == 1);
  CHECK(positions == 0);
  REQUIRE(result.notes.size() == 1);
  CHECK_THAT(result.notes[0], Contains("interrupted while simulating schedule"));
  CHECK(fs::exists(folder / "session.states"));
  CHECK(summarise(result, input, options).run.seconds == 0);
}

TEST_CASE("more neighbours than there can be states change nothing, and what no memory holds is refused") {
  const TemporaryFolder folder;
  SessionOptions options = virtual_options(0.5);
  options.workers.cost = ConstantCost{0.002};
  options.model.fit.neighbours = 400;  // of at most 6 x 6 x 6
  const std::string few = logs(small_input(), options, folder / "few");
  options.model.fit.neighbours = 100'000;
  CHECK(logs(small_input(), options, folder / "many") == few);
  options.planning.placement = Placement::path;
  SessionInput wide = small_input();
  wide.touched.space.spacing = 0.001;
  try {
    make_plan(wide, options);
    FAIL("accepted");
  } catch (const InputError& error) {
    CHECK(error.place().key == "model.neighbours");
    CHECK_THAT(error.what(), Contains("is 100000", "GB", "expected at most"));
  }
  options.model.fit.neighbours = 100;
  CHECK_NOTHROW(make_plan(wide, options));
}

TEST_CASE("a box without room for a lattice cell: a note says why nothing is a first visit") {
  SessionOptions options = virtual_options(0.3);
  options.motion.device = PathMotion{.path = PathName::circle, .speed = 0.06};
  options.model.first_guess = false;  // the beam is slender, which would be a note too
  Box box = small_input().touched.space.box;
  const auto notes = [&](double spacing, double cell) {
    SessionInput input = small_input();
    input.touched.space.spacing = spacing;
    input.touched.space.box = box;
    options.judging.visit_cell = cell;
    const SessionResult result = run_session(input, options);
    const bool first =
        std::ranges::any_of(result.frames, [](const FrameRecord& f) { return f.judged.first_visit; });
    std::string all = first ? "visits " : "";
    for (const std::string& note : result.notes) all += note;
    return all;
  };
  CHECK_THAT(notes(0.05, 0), Catch::StartsWith("no cell of a lattice of 0.05 m fits the box") &&
                                 Contains("there is no load"));
  CHECK_THAT(notes(0.006, 0.05), Catch::StartsWith("no cell of a lattice of 0.05 m") && !Contains("load"));
  CHECK_THAT(notes(0.05, 0), Contains("nothing but rest was solved"));
  box = {Vec3::Constant(0.001), Vec3::Constant(0.005)};
  CHECK_THAT(notes(0.006, 0), Contains("no cell of a lattice of 0.006 m",
                                       "holds no position of the lattice of 0.006 m: nothing could") &&
                                  !Contains("rest was"));
  CHECK_THAT(notes(0.006, 0.001),
             Contains("holds no position of the lattice of 0.006 m: nothing could be solved"));
  box = small_input().touched.space.box;
  CHECK(notes(0.006, 0) == "visits ");
  CHECK(notes(0.012, 0) == "visits ");
}

TEST_CASE("a second wish to end cuts the patience with references short") {
  std::atomic<bool> stop{false}, hurry{false};
  SessionOptions options = virtual_options(1);
  options.motion.device = PathMotion{.path = PathName::circle, .speed = 0.06};
  options.judging.reference_step = 1e-5;
  options.workers.threads = 1;
  options.stop.interrupted = &stop;
  options.stop.hurried = &hurry;
  options.stop.patience = 1e6;  // as long as it takes
  const SessionResult result =
      run_session(small_input(), options, {.progress = [&](const SessionProgress& p) {
                    stop = hurry = stop || p.phase == SessionPhase::references;
                  }});
  CHECK(result.interrupted());
  CHECK(result.frames.size() == 1000);
  CHECK_THAT(result.notes.back(), Contains("references were not waited for"));
}

TEST_CASE("records of the cache of references that are not what was written are solved anew and replaced") {
  const TemporaryFolder folder;
  SessionInput input = small_input();
  input.touched.identity = {{"mesh", "small"}};
  input.files.cache = folder / "cache";
  SessionOptions options = virtual_options(0.5);
  const std::string first = logs(input, options, folder / "first");
  fs::path cache;
  for (const auto& entry : fs::directory_iterator(input.files.cache))
    if (entry.path().extension() == ".states") cache = entry.path();
  REQUIRE_FALSE(cache.empty());
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(cache.c_str(), &database) == SQLITE_OK);
  CHECK(sqlite3_exec(database, "UPDATE states SET fz = fz + 1 WHERE id <= 3", nullptr, nullptr, nullptr) ==
        SQLITE_OK);
  sqlite3_close(database);
  const SessionResult told = run_session(input, options);
  REQUIRE(told.warnings.size() == 1);
  CHECK_THAT(told.warnings[0],
             Catch::StartsWith(cache.string()) && Contains("3 states have a wrong checksum"));
  CHECK(logs(input, options, folder / "second") == first);
  CHECK(run_session(input, options).warnings.empty());
}

TEST_CASE("a run that is interrupted while its references are solved ends without them, and says so") {
  std::atomic<bool> stop{false};
  SessionOptions options = virtual_options(1);
  options.motion.device = PathMotion{.path = PathName::circle, .speed = 0.06};
  options.judging.reference_step = 1e-5;
  options.workers.threads = 1;
  options.stop.interrupted = &stop;
  options.stop.patience = 0;
  const SessionResult result = run_session(
      small_input(), options,
      {.progress = [&](const SessionProgress& p) { stop = stop || p.phase == SessionPhase::references; }});
  CHECK(result.interrupted());
  CHECK(result.frames.size() == 1000);
  CHECK_THAT(result.notes.back(), Contains("references were not waited for"));
  const auto without = [](const FrameRecord& f) {
    return f.judged.sampled && !std::isfinite(f.judged.error);
  };
  CHECK(std::ranges::any_of(result.frames, without));
}
