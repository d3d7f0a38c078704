// The warnings before the figures of a session, and the numbers behind them.

#include "geometry/states/state_outcome.hpp"
#include "scheduling/record/attention.hpp"
#include "scheduling/record/summary_columns.hpp"
#include "small_body.hpp"

namespace {

// 1000 frames at rest inside the box, all of them samples without error.
SessionResult quiet_run(std::size_t samples = 1000) {
  SessionResult result;
  result.counts.solved = 1;
  for (std::size_t k = 0; k < 1000; ++k) {
    FrameRecord frame{.t = 1e-3 * static_cast<double>(k)};
    if (k < samples) {
      frame.judged.sampled = frame.judged.first_visit = true;
      frame.judged.reference = frame.force = Vec3(1, 0, 0);
      frame.judged.error = 0;
    }
    result.frames.push_back(frame);
  }
  return result;
}

std::vector<std::string> lines(const SessionResult& result) {
  return attention(summarise(result, small_input(), virtual_options(1)));
}

}  // namespace

TEST_CASE("nothing is said first about a session that has nothing to hide") {
  CHECK(lines(quiet_run()).empty());
}

TEST_CASE("a session without a state says that its forces are none of the body") {
  SessionResult result = quiet_run();
  result.counts.solved = 0;
  REQUIRE(lines(result).size() == 1);
  CHECK_THAT(lines(result)[0], Catch::StartsWith("no state was solved"));
}

TEST_CASE("the mesh's own error comes first only where a hand would feel it and where it is the larger one") {
  SessionSummary summary = summarise(quiet_run(), small_input(), virtual_options(1));
  summary.error.samples.p95 = 0.0031;
  summary.error.mesh = {.error = 0.0043, .how = "a finer mesh"};
  CHECK(attention(summary).empty());
  REQUIRE(remarks(summary).size() == 1);
  CHECK(remarks(summary)[0] == "the mesh itself errs by 0.4 %, a hand feels 7 % (a finer mesh)");
  summary.error.mesh.error = 0.12;
  REQUIRE(attention(summary).size() == 1);
  CHECK_THAT(attention(summary)[0],
             Catch::StartsWith("the mesh itself errs by 12 % of the force, a hand feels 7 %"));
  summary.error.samples.p95 = 0.2;
  CHECK(attention(summary).empty());
  summary.error.samples.p95 = unknown;
  REQUIRE(attention(summary).size() == 1);
  CHECK_THAT(attention(summary)[0], Catch::EndsWith("quadratic elements help"));
}

TEST_CASE("a tip far from its site: what holds the site is named, and no friction of 0 is to be lowered") {
  SessionSummary summary = summarise(quiet_run(), small_input(), virtual_options(1));
  summary.motion.touch = TouchNumbers{.beyond = 0.25, .friction = 0.3};
  REQUIRE(attention(summary).size() == 1);
  CHECK_THAT(attention(summary)[0], Contains("contact.friction = 0.3 holds the site; lower it"));
  summary.motion.touch->friction = 0;
  for (const auto& [holder, words] : {std::pair(SiteHolder::edge, "an edge of the body holds the site"),
                                      std::pair(SiteHolder::clamp, "the border of the clamp holds the site"),
                                      std::pair(SiteHolder::lag, "the site is behind"),
                                      std::pair(SiteHolder::minimum, "its energy is least")}) {
    summary.motion.touch->holder = holder;
    REQUIRE(attention(summary).size() == 1);
    CHECK_THAT(attention(summary)[0], Contains("25 % of the time in touch") && Contains(words));
    CHECK_THAT(attention(summary)[0], !Contains("lower it"));
  }
}

TEST_CASE("what passivity control changes of the force is said, as the errors do not hold it") {
  SessionSummary summary = summarise(quiet_run(), small_input(), virtual_options(1));
  summary.energy.control.added_p50 = 0.2;
  summary.energy.control.added_p95 = 0.75;
  REQUIRE(attention(summary).size() == 1);
  CHECK_THAT(attention(summary)[0], Contains("by 20 % (p50), 75 % (p95)"));
  summary.energy.control.added_p95 = 0.005;
  CHECK(attention(summary).empty());
}

TEST_CASE("what holding the force for a frame gives to the hand is said of unstable sessions alone") {
  SessionSummary summary = summarise(quiet_run(), small_input(), virtual_options(1));
  summary.energy.stability = StabilityReport{.stable = false, .since = 0.1, .hold = 0.0335};
  REQUIRE(attention(summary).size() == 1);
  CHECK_THAT(attention(summary)[0], Contains("the hand got 0.0335 J in all because each force is held"));
  summary.energy.stability->stable = true;  // damping absorbed it
  CHECK(attention(summary).empty());
}

TEST_CASE("an error bar that held too seldom in a label is said with that label") {
  SessionResult result = quiet_run();
  for (std::size_t k = 0; k < 100; ++k) {
    result.frames[k].label = Label::blank;
    result.frames[k].bar.half_width.fill(k < 40 ? 1.0 : 1e-3);
    result.frames[k].force = Vec3(1.01, 0, 0);
  }
  REQUIRE(lines(result).size() == 1);
  CHECK_THAT(lines(result)[0], Contains("40 % of 100 samples labelled blank"));
}

TEST_CASE("a motion that starts pressed in while zero is rendered is said, with the time until it is right") {
  SessionResult result = quiet_run();
  for (std::size_t k = 0; k < 400; ++k) {
    result.frames[k].force.setZero();
    result.frames[k].judged.reference = Vec3(2.3, 0, 0);
    result.frames[k].judged.error = 1;
  }
  REQUIRE(lines(result).size() == 1);
  CHECK_THAT(lines(result)[0], Contains("starts pressed in", "2.3 N", "0 N was rendered", "0.4 s"));
  for (FrameRecord& frame : result.frames) frame.force.setZero();
  CHECK_THAT(lines(result)[0], Contains("no later sample was within the JND"));
}

TEST_CASE("more than 5 % of frames clamped is said first of all, with the limit") {
  SessionResult result = quiet_run();
  result.safety = {.clamped = 50};
  CHECK(lines(result).empty());
  result.safety.clamped = 985;
  for (std::size_t k = 0; k < 380; ++k) result.frames[k].at = Vec3(1, 0, 0);
  SessionSummary summary = summarise(result, small_input(), virtual_options(1));
  summary.safety.force_limit = 3.3;
  CHECK(attention(summary).size() == 1);  // outside the box, and right all the same: a remark
  CHECK_THAT(remarks(summary).back(), Contains("38.0 %", "without an error that a hand feels"));
  summary.error.samples.within_jnd = 0.95;
  REQUIRE(attention(summary).size() == 2);
  CHECK_THAT(attention(summary)[0], Contains("98.5 %", "3.3 N"));
  CHECK_THAT(attention(summary)[1], Contains("38.0 %", "outside the box"));
}

TEST_CASE("a position on a face of the box is inside") {
  SessionResult result = quiet_run();
  for (FrameRecord& frame : result.frames) frame.at = Vec3(0.012 + 1e-12, 0, 0);
  CHECK(summarise(result, small_input(), virtual_options(1)).motion.outside == 0);
}

TEST_CASE("a percentage of few samples is given as counts") {
  CHECK(share_of_samples(1.0, 1) == "1 of 1");
  CHECK(share_of_samples(2.0 / 3, 3) == "2 of 3");
  CHECK(share_of_samples(0.981, 213) == "98.1 % of 213");
  CHECK(share_of_samples(unknown, 0) == "unknown");
  REQUIRE(lines(quiet_run(1)).size() == 1);
  CHECK_THAT(lines(quiet_run(1))[0], Contains("errors rest on 1 sample") && !Contains("samples"));
}

TEST_CASE("states with inverted elements do not count as solved, and are said") {
  SessionResult result = quiet_run();
  result.counts = {.start = 1, .solved = 3};
  for (const double jacobian : {-0.5, 0.5, -0.1, 0.2}) {
    State state;
    state.solve.status = SolveStatus::converged;
    state.solve.min_jacobian = jacobian;
    result.states.push_back(state);
  }
  CHECK(outcome(result.states[0]) == SolveStatus::inverted);
  CHECK(outcome(result.states[1]) == SolveStatus::converged);
  const SessionSummary summary = summarise(result, small_input(), virtual_options(1));
  CHECK(summary.states.inverted == 1);  // the first was known at the start
  CHECK(summary.states.solved == 2);
  REQUIRE(attention(summary).size() == 1);
  CHECK_THAT(attention(summary)[0], Catch::StartsWith("1 of 3 solved states have inverted elements"));
}

TEST_CASE("the later columns are the last ones of the summary") {
  const SessionSummary summary = summarise(quiet_run(), small_input(), virtual_options(1));
  const std::vector<Column> all = summary_columns(summary), later = later_columns(summary);
  REQUIRE(all.size() > later.size());
  for (std::size_t i = 0; i < later.size(); ++i)
    CHECK(all[all.size() - later.size() + i].name == later[i].name);
}
