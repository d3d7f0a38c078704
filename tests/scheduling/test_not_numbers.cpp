// User-supplied parts that return NaN or lack a setting: this is reported, not silently ignored.

#include "scheduling/common/arguments.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/workers/cost.hpp"
#include "small_body.hpp"

namespace {

// Nearest first, but for every third candidate it divides zero by zero.
struct Careless final : Policy {
  std::string_view name() const override { return "careless"; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    if (candidate.order % 3 == 0) return std::numeric_limits<double>::quiet_NaN();
    return 1 / (1e-3 + (candidate.at - view.hip.at).norm());
  }
};

// Nearest first, as the negative distance, unless it is shifted.
struct Distance final : Policy {
  double shift;
  explicit Distance(double s) : shift(s) {}
  std::string_view name() const override { return "distance"; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    return shift - (candidate.at - view.hip.at).norm();
  }
};

// Infinite for one candidate far from rest.
struct Favourite final : Policy {
  mutable Vec3 at = Vec3::Zero();
  std::string_view name() const override { return "favourite"; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    if (candidate.order != 20) return 1 / (1e-3 + (candidate.at - view.hip.at).norm());
    at = candidate.at;
    return std::numeric_limits<double>::infinity();
  }
};

// Returns NaN (zero divided by zero) beyond some distance from rest.
struct CarelessCost final : CostModel {
  explicit CarelessCost(double from) : from_(from) {}
  double seconds(const Vec3& at) const override {
    return at.norm() < from_ ? 0.02 : std::numeric_limits<double>::quiet_NaN();
  }

 private:
  double from_;  // [m]
};

struct CarelessPredictor final : Predictor {
  HipSample last;
  void observe(const HipSample& sample) override { last = sample; }
  Prediction predict(double horizon) const override {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {.horizon = horizon, .at = horizon > 0.2 ? Vec3::Constant(nan) : last.at, .deviation = nan};
  }
};

std::string note_about(const SessionResult& result, const std::string& word) {
  for (const std::string& note : result.notes)
    if (note.find(word) != std::string::npos) return note;
  return "";
}

}  // namespace

TEST_CASE("priorities that are not numbers are counted in a note that names the policy") {
  SessionInput input = small_input(Law::linear);
  SessionOptions options = virtual_options(0.3);
  CHECK(note_about(run_session(input, options), "not numbers").empty());
  input.parts.policy = std::make_shared<Careless>();
  const SessionResult result = run_session(input, options);
  CHECK_THAT(note_about(result, "not numbers"), Catch::StartsWith("policy careless gave ") &&
                                                    Contains(" not numbers, 0 infinite, 0 negative; ") &&
                                                    Catch::EndsWith("last"));
  CHECK(result.counts.solved > 0);
}

TEST_CASE("negative and infinite priorities are sorted by <, and counted") {
  SessionInput input = small_input(Law::linear);
  SessionOptions options = virtual_options(0.3);
  options.planning.preempt = false;  // compares ratios, which negative numbers do not have
  const auto order = [&](double shift, std::string& note) {
    input.parts.policy = std::make_shared<Distance>(shift);
    const SessionResult result = run_session(input, options);
    note = note_about(result, "policy distance gave");
    std::vector<Vec3> positions;
    for (const DispatchRecord& job : result.dispatch) positions.push_back(job.at);
    return positions;
  };
  std::string lawful, negative;
  const std::vector<Vec3> expected = order(1, lawful);  // [m]: no priority is negative
  CHECK(order(0, negative) == expected);
  CHECK(lawful.empty());
  CHECK_THAT(negative, Contains("finite numbers of at least 0: 0 not numbers, 0 infinite, ") &&
                           !Contains(" 0 negative"));

  const auto favourite = std::make_shared<Favourite>();
  input.parts.policy = favourite;
  const SessionResult result = run_session(input, options);
  const auto first = std::ranges::find_if(result.dispatch, [](const auto& job) { return !job.at.isZero(0); });
  REQUIRE(first != result.dispatch.end());
  CHECK(favourite->at.norm() > 0);
  CHECK(first->at == favourite->at);
  CHECK_THAT(note_about(result, "policy favourite gave"),
             Contains("0 not numbers, ") && !Contains(", 0 infinite"));
}

TEST_CASE("predictions that are not numbers are counted in a note, and the session goes on without them") {
  SessionInput input = small_input(Law::linear);
  SessionOptions options = virtual_options(0.3);
  CHECK(note_about(run_session(input, options), "predictor").empty());
  input.parts.predictor = std::make_shared<CarelessPredictor>();
  const SessionResult result = run_session(input, options);
  CHECK_THAT(note_about(result, "predictor"), Catch::StartsWith("the predictor gave ") &&
                                                  Contains("the hand counted as staying where it was"));
  CHECK(result.counts.solved > 0);
  CHECK(result.failures.empty());
}

TEST_CASE(
    "a cost model that answers no time is refused before the session, or named where it ends the session") {
  SessionInput input = small_input(Law::linear);
  const SessionOptions options = virtual_options(0.3);
  input.parts.cost = std::make_shared<CarelessCost>(1e-6);
  CHECK_THROWS_WITH(make_plan(input, options),
                    Catch::StartsWith("cost: the cost model charges nan s for a state at ") &&
                        Catch::EndsWith("expected a time from 0 to 1e+06 s"));

  struct Endless final : CostModel {
    double seconds(const Vec3&) const override { return std::numeric_limits<double>::infinity(); }
  };
  input.parts.cost = std::make_shared<Endless>();
  CHECK_THROWS_WITH(make_plan(input, options), Catch::StartsWith("cost: the cost model charges inf s"));

  // Wrong at one position that the coarse grid leaves out: the planner asks for it while the session runs.
  struct AtRest final : CostModel {
    double seconds(const Vec3&) const override { return 0.02; }
    double rest_seconds() const override { return -1; }
  };
  input.parts.cost = std::make_shared<AtRest>();
  const SessionResult result = run_session(input, options);
  REQUIRE(result.failures.size() == 1);
  CHECK_THAT(result.failures.front(),
             Catch::StartsWith("planning failed: cost: ") && Contains("charges -1 s for the state at rest"));
}

TEST_CASE("a setting that a part requires is refused where it is missing or empty, with the part's text") {
  const auto refusal = [](const PartSettings& settings, const std::string& key) {
    return error_of([&] { Arguments({.key = "device", .value = "mine"}, settings).required_text(key); });
  };
  CHECK(Arguments({.key = "device"}, {{"file", "a.csv"}}).required_text("file") == "a.csv");
  CHECK_THAT(refusal({}, "file"), Contains("mine", "file is missing, expected file=TEXT"));
  CHECK_THAT(refusal({{"file", ""}}, "file"), Contains("is missing"));
  CHECK_THAT(refusal({}, ""), Contains("the text after the colon is missing"));
}
