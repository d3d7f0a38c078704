// reproduce.

#include <fmt/format.h>

#include "apps/scene/laboratory.hpp"
#include "scheduling/placement/auto_spacing.hpp"
#include "scheduling/study/calibration.hpp"
#include "tests/support/executable.hpp"

TEST_CASE("the paper's experiments on a small beam",
          "[laboratory]" SLOW("runs all experiments of the paper")) {
  const BeamShop shop;
  const auto outcome = shop.run(
      "reproduce all beam.toml --depth 9 --interval 0.4 --rounds 2 --travel 0.1 --workers 2,3 --json --quiet "
      "-o out");
  const json found = outcome.json();
  const std::string files = shop.files();
  for (const char* file : {"timing.csv", "extrapolation.csv", "damping.csv", "energy.csv", "speed.csv",
                           "report.html", "summary.json"})
    CHECK_THAT(files, Contains(std::string("out/") + file));
  const std::string page = text_of(shop.path() / "out/report.html");
  CHECK_THAT(page, Contains("The paper found", "We found"));
  CHECK_THAT(page, !Contains("src=\"") && !Contains("href=\"http"));

  const auto& speeds = found["experiments"]["speed"]["rows"];
  REQUIRE(speeds.size() == 2);
  CHECK(speeds[0]["workers"] == 2);
  for (const auto& row : speeds) CHECK(row["speed"].get<double>() >= row["predecessor"].get<double>());

  const auto& curves = found["experiments"]["extrapolation"]["curves"];
  REQUIRE(curves.size() == 9);
  double paper_gap = 0, our_gap = 1e9;
  for (const auto& curve : curves) {
    CHECK(curve["error_tight"]["max"].is_number());
    CHECK(curve["largest_jump_newton"]["newton"].get<double>() >=
          curve["largest_jump"]["newton"].get<double>());
    CHECK(curve["largest_jump"]["jnd"].get<double>() >= curve["largest_jump_newton"]["jnd"].get<double>());
    if (curve["setup"] != "gap") continue;
    const bool ours = curve["method"].get<std::string>().find("Hermite") != std::string::npos;
    if (ours)
      our_gap = curve["largest_jump"]["jnd"];
    else {
      CHECK(curve["far_side_enters"]["s"].get<double>() < curve["near_side_leaves"]["s"].get<double>());
      paper_gap = std::max(paper_gap, curve["largest_jump"]["jnd"].get<double>());
    }
  }
  CHECK(our_gap < paper_gap);
  // The largest values by either measure are those of the table.
  const double gap_end = found["experiments"]["extrapolation"]["gap"];
  std::istringstream csv(text_of(shop.path() / "out/extrapolation.csv"));
  std::map<std::string, std::array<double, 3>> most;  // by setup and method: N; in the gap N, JND
  for (std::string line; std::getline(csv, line);) {
    const std::size_t name_end = line.find("\",");
    if (name_end == std::string::npos) continue;
    std::vector<std::string> fields;
    std::istringstream rest(line.substr(name_end + 2));
    for (std::string field; std::getline(rest, field, ',');) fields.push_back(field);
    const double s = std::stod(fields[0]), jump = std::stod(fields[8]), jnd = std::stod(fields[9]);
    auto& m = most[line.substr(0, name_end)];
    m[0] = std::max(m[0], jump);
    if (s > 0 && s <= gap_end + 1e-9) m[1] = std::max(m[1], jump), m[2] = std::max(m[2], jnd);
  }
  for (const auto& curve : curves) {
    const auto& m = most.at(curve["setup"].get<std::string>() + ",\"" + curve["method"].get<std::string>());
    CHECK(curve["largest_jump_newton"]["newton"] == Approx(m[0]).epsilon(1e-3));
    if (curve["setup"] != "gap") continue;
    CHECK(curve["in_gap"]["largest_jump_newton"]["newton"] == Approx(m[1]).epsilon(1e-3));
    CHECK(curve["in_gap"]["largest_jump"]["jnd"] == Approx(m[2]).epsilon(1e-3));
    CHECK(curve["in_gap"]["largest_jump"]["s"].get<double>() <= gap_end + 1e-9);
    for (const char* share : {"p50", "p95", "max"}) CHECK(curve["in_gap"]["error_tight"][share].is_number());
  }

  const auto& runs = found["experiments"]["damping"]["runs"];
  REQUIRE(runs.size() == 4);
  for (const auto& run : runs) {
    CHECK(run["groups"].size() == 8);
    CHECK(run["error_after"].get<double>() <
          run["error_before"].get<double>() + 1e-9);  // the space is full in the end
    if (run["switch"] != "none") CHECK(run["frames_over_bound"] == 0);
  }
  // The change that a switch may make in a frame of 1 ms is smaller than the undamped change.
  CHECK(runs[1]["max_frame_change"]["newton"].get<double>() <=
        runs[0]["max_frame_change"]["newton"].get<double>());

  const auto& energy = found["experiments"]["energy"];
  CHECK(energy["loops"]["centres"].size() == 4);
  bool offline = false;
  for (const auto& row : energy["rows"]) {
    if (row["method"] == "energy interpolant, n 25") CHECK(row["max"].get<double>() < 1e-6);
    offline = offline || row["method"] == "offline-rbf";
    // Spacing 4 mm.
    const bool moves = row["set"] != "fixed",
               older = row["method"].get<std::string>().find("n ") == std::string::npos;
    CHECK(row["half_axes"][0] == Approx(moves || older ? 0.010 : 0.0048));
    CHECK(row["half_axes"][1] == Approx(0.8 * row["half_axes"][0].get<double>()));
  }
  CHECK(offline);
  CHECK_THAT(page, Contains("Half axes: 4.8 and 3.84 mm") && !Contains("r costs what r3 costs"));
  const auto& times = found["experiments"]["timing"]["rows"];
  if (times[0]["n"] == 100 && times[1]["n"] == 100) {
    CHECK(times[0]["kernel"] == "linear");
    CHECK_THAT(
        page, Contains(fmt::format("With 100 states r takes {:.2f} times as long as r3 to refit",
                                   times[0]["refit_us"].get<double>() / times[1]["refit_us"].get<double>())));
  }
  for (const auto& row : found["experiments"]["timing"]["rows"]) CHECK(row["evaluate_us"].get<double>() > 0);

  // The second run solves nothing and finds the same.
  const auto again = shop.run("reproduce extrapolation beam.toml --depth 9 --json --quiet -o again");
  CHECK(again.json()["experiments"]["extrapolation"] == found["experiments"]["extrapolation"]);
}

TEST_CASE("sustained speed on the built-in scene", "[laboratory]" SLOW("runs sessions at rising speeds")) {
  const Workshop shop;
  const auto outcome = shop.run(
      "reproduce speed --set body.elements=300 --travel 0.05 --workers 2 --seeds 2 --json --quiet -o out");
  const json speed = outcome.json()["experiments"]["speed"];
  REQUIRE(speed["rows"].size() == 1);
  CHECK(speed["seeds"] == 2);
  CHECK_THAT(text_of(shop.path() / "out/speed.toml"), Contains("seeds = [1, 2]"));
  const json& row = speed["rows"][0];
  CHECK(row["speed"].is_number());
  CHECK(row["rest_known_before"].is_number());
  CHECK(row["our_start_for_all"]["seed_paper"].is_number());
  const std::string csv = text_of(shop.path() / "out/speed.csv");
  for (const char* step :
       {"predecessor, tricubic 18 mm", "seed paper: r3 n=100, 6 mm", "default, motion known (clairvoyant)",
        "+ rest first", "+ first guess (default)", "seed paper, 12 mm + our start"})
    CHECK_THAT(csv, Contains(step));
}

TEST_CASE("what should vanish and does not is exit 1, with all that was found", "[laboratory]") {
  const BeamShop shop;
  // With a tiny just noticeable difference, every jump can be felt.
  const Workshop::Outcome outcome = shop.forefeel(
      "reproduce extrapolation beam.toml --depth 9 --json --set session.jnd.share=1e-12 --set "
      "session.jnd.floor=1e-12 -o out");
  INFO(outcome.err);
  CHECK(outcome.code == 1);
  CHECK(outcome.json()["experiments"]["extrapolation"]["curves"].size() == 9);
  CHECK_THAT(outcome.err, Contains("Hermite", "jumps by"));
  CHECK_THAT(shop.files(), Contains("out/report.html"));
}

TEST_CASE("experiments that cannot be run", "[laboratory]") {
  const BeamShop shop;
  check_refused(shop, "reproduce", {"WHAT"});
  check_refused(shop, "reproduce timming beam.toml -o out", {"did you mean 'timing'"});
  check_refused(shop, "reproduce speed --set state_space.spacing=0.012 -o out",
                {"state_space.spacing", "predecessor"});
  check_refused(shop, "reproduce speed --travel nan -o out", {"--travel"});
  check_refused(shop, "reproduce speed --workers 2 4 4 -o out", {"--workers", "4 twice"});
  check_refused(shop, "reproduce speed --set session.workers=3 -o out", {"session.workers"});
  check_refused(shop, "reproduce speed --set session.cost=bogus -o out", {"cost bogus"});
  check_refused(shop, "reproduce speed --set session.device=hand:touch -o out/deep/",
                {"no speed to set", "hand:touch"});
  check_refused(shop, "reproduce speed beam.toml --set session.device=path:line,speed=0.1 -o out",
                {"names its speed already"});
  check_refused(shop, "reproduce all beam.toml --set session.arrivals=beam.toml -o out",
                {"reproduce speed: sustained: has no effect", "arrivals"});
  check_refused(shop, "reproduce speed --set session.latency=1e9 -o out", {"--set session.latency"});
  const auto kept = shop.write("kept/speed.toml", "of an earlier run");
  check_refused(shop, "reproduce speed --set session.device=hand:touch -o kept", {"no speed to set"});
  CHECK(text_of(kept) == "of an earlier run");
  check_refused(shop, "reproduce all --set session.policy=fifo -o out", {"session.policy"});
  check_refused(shop, "reproduce timing absent.toml -o out", {"absent.toml"});
  check_refused(shop, "reproduce energy beam.toml --gap 4 -o out", {"--gap", "energy", "extrapolation"});
  check_refused(shop, "reproduce damping beam.toml --rounds 4 -o out", {"--rounds", "damping", "timing"});
  check_refused(shop, "reproduce extrapolation beam.toml --workers 4 -o out", {"--workers", "speed"});
  check_refused(shop, "reproduce timing beam.toml", {"--output"});
  check_refused(shop, "reproduce timing beam.toml -o beam.toml/out", {"beam.toml/out"});
  check_refused(shop, "reproduce damping beam.toml --interval 0 -o out", {"--interval"});
  check_refused(shop, "reproduce damping beam.toml --depth 2 -o out", {"--depth"});
  check_refused(shop, "classify --calibrate absent.toml", {"absent.toml"});
  check_refused(shop, "classify --calibrate beam.toml --grid 0.01", {"--calibrate"});
  check_refused(shop, "classify absent.states --calibrate beam.toml", {"absent.states"});
}

TEST_CASE("rank correlation and intervals of a share", "[laboratory]") {
  CHECK(rank_correlation({1, 2, 3, 4}, {10, 20, 30, 1e9}) == Approx(1));
  CHECK(rank_correlation({1, 2, 3, 4}, {4, 3, 2, 1}) == Approx(-1));
  CHECK(rank_correlation({1, 2, std::nan(""), 4}, {1, 2, 9, INFINITY}) == Approx(1));
  // scipy.stats.spearmanr([1, 2, 2, 3, 5], [2, 1, 4, 3, 3])
  CHECK(rank_correlation({1, 2, 2, 3, 5}, {2, 1, 4, 3, 3}) == Approx(0.36842105263157904));
  CHECK(std::isnan(rank_correlation({1, 1, 1}, {1, 2, 3})));
  // statsmodels proportion_confint(3, 20, method="wilson")
  CHECK(wilson_interval(3, 20).low == Approx(0.0523687).epsilon(1e-5));
  CHECK(wilson_interval(3, 20).high == Approx(0.3604189).epsilon(1e-5));
  CHECK(wilson_interval(0, 50).low == 0);
  CHECK(wilson_interval(50, 50).high == 1);
}
