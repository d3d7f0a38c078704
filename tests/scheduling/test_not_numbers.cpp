// Parts of a user that answer with what is no number, or lack a setting: said, not silently passed over.

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "geometry/common/error.hpp"
#include "scheduling/common/arguments.hpp"
#include "scheduling/session/session.hpp"
#include "small_body.hpp"

using namespace forefeel;
using testing::small_input;
using testing::virtual_options;

namespace {

// Nearest first, but for every third candidate it divides zero by zero.
struct Careless final : Policy {
  std::string_view name() const override { return "careless"; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    if (candidate.order % 3 == 0) return std::numeric_limits<double>::quiet_NaN();
    return 1 / (1e-3 + (candidate.at - view.hip.at).norm());
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
  CHECK_THAT(note_about(result, "not numbers"),
             Catch::StartsWith("policy careless gave ") && Catch::EndsWith("they counted as the lowest"));
  CHECK(result.counts.solved > 0);
}

TEST_CASE("a setting that a part requires is refused where it is missing or empty, with the part's text") {
  const auto refusal = [](const PartSettings& settings, const std::string& key) {
    try {
      Arguments({.key = "device", .value = "mine"}, settings).required_text(key);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(Arguments({.key = "device"}, {{"file", "a.csv"}}).required_text("file") == "a.csv");
  CHECK_THAT(refusal({}, "file"),
             Catch::Contains("mine") && Catch::Contains("file is missing, expected file=TEXT"));
  CHECK_THAT(refusal({{"file", ""}}, "file"), Catch::Contains("is missing"));
  CHECK_THAT(refusal({}, ""), Catch::Contains("the text after the colon is missing"));
}
