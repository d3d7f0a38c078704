// reproduce, bench switch, calibration of labels, spacing = "auto".

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <sstream>

#include "apps/calibration.hpp"
#include "apps/laboratory.hpp"
#include "scheduling/auto_spacing.hpp"
#include "tests/apps/executable.hpp"

using namespace forefeel;
using test::beam_scene;
using test::Workshop;

namespace {

std::string read(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// W = a/2 |x|^2 + b/4 |x|^4: a stiffening field, exact everywhere.
State field_state(const Vec3& x) {
  State s;
  s.at = x;
  s.force = -(40 + 2e4 * x.squaredNorm()) * x;
  s.stiffness = (40 + 2e4 * x.squaredNorm()) * Mat3::Identity() + 4e4 * x * x.transpose();
  s.status = SolveStatus::converged;
  return s;
}

}  // namespace

TEST_CASE("the paper's experiments on a small beam", "[laboratory]") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const Workshop::Outcome outcome =
      shop.forefeel("reproduce all beam.toml --depth 9 --interval 0.4 --rounds 2 --travel 0.1 --workers 2,3 --json --quiet -o out");
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  const nlohmann::json found = outcome.json();
  const std::string files = shop.files();
  for (const char* file :
       {"timing.csv", "extrapolation.csv", "damping.csv", "energy.csv", "speed.csv", "report.html", "summary.json"})
    CHECK_THAT(files, Catch::Contains(std::string("out/") + file));
  const std::string page = read(shop.path() / "out/report.html");
  CHECK_THAT(page, Catch::Contains("The paper found") && Catch::Contains("We found"));
  CHECK_THAT(page, !Catch::Contains("src=\"") && !Catch::Contains("href=\"http"));

  const auto& speeds = found["experiments"]["speed"]["rows"];
  REQUIRE(speeds.size() == 2);
  CHECK(speeds[0]["workers"] == 2);
  for (const auto& row : speeds) CHECK(row["speed"].get<double>() >= row["predecessor"].get<double>());

  const auto& curves = found["experiments"]["extrapolation"]["curves"];
  REQUIRE(curves.size() == 9);
  double paper_gap = 0, our_gap = 1e9;
  for (const auto& curve : curves) {
    CHECK(curve["error_tight"]["max"].is_number());
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

  const auto& runs = found["experiments"]["damping"]["runs"];
  REQUIRE(runs.size() == 4);
  for (const auto& run : runs) {
    CHECK(run["groups"].size() == 8);
    CHECK(run["error_after"].get<double>() <
          run["error_before"].get<double>() + 1e-9);  // the space is full in the end
    if (run["switch"] != "none") CHECK(run["frames_over_bound"] == 0);
  }
  // What a switch may change in a frame of 1 ms is less than what comes undamped.
  CHECK(runs[1]["max_frame_change"]["newton"].get<double>() <=
        runs[0]["max_frame_change"]["newton"].get<double>());

  for (const auto& row : found["experiments"]["energy"]["rows"])
    if (row["method"] == "energy interpolant, n 25") CHECK(row["max"].get<double>() < 1e-6);
  for (const auto& row : found["experiments"]["timing"]["rows"]) CHECK(row["evaluate_us"].get<double>() > 0);

  // The second time nothing is solved, and the same is found.
  const Workshop::Outcome again =
      shop.forefeel("reproduce extrapolation beam.toml --depth 9 --json --quiet -o again");
  REQUIRE(again.code == 0);
  CHECK(again.json()["experiments"]["extrapolation"] == found["experiments"]["extrapolation"]);
}

TEST_CASE("sustained speed on the built-in scene", "[laboratory]") {
  const Workshop shop;
  const Workshop::Outcome outcome =
      shop.forefeel("reproduce speed --set body.elements=300 --travel 0.05 --workers 2 --seeds 2 --json --quiet -o out");
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  const nlohmann::json speed = outcome.json()["experiments"]["speed"];
  REQUIRE(speed["rows"].size() == 1);
  CHECK(speed["seeds"] == 2);
  CHECK_THAT(read(shop.path() / "out/speed.toml"), Catch::Contains("seeds = [1, 2]"));
  const nlohmann::json& row = speed["rows"][0];
  CHECK(row["speed"].is_number());
  CHECK(row["rest_known_before"].is_number());
  CHECK(row["rest_first_for_all"]["seed_paper"].is_number());
  const std::string csv = read(shop.path() / "out/speed.csv");
  for (const char* step : {"predecessor, tricubic 18 mm", "seed paper: r3 n=100, 6 mm", "default, motion known (clairvoyant)",
                           "+ rest first (default)", "seed paper, 12 mm + rest first"})
    CHECK_THAT(csv, Catch::Contains(step));
}

TEST_CASE("what should vanish and does not is exit 1, with all that was found", "[laboratory]") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  // A hand that feels everything: no jump is below what it can tell.
  const Workshop::Outcome outcome = shop.forefeel(
      "reproduce extrapolation beam.toml --depth 9 --json --set session.jnd.share=1e-12 --set session.jnd.floor=1e-12 -o out");
  INFO(outcome.err);
  CHECK(outcome.code == 1);
  CHECK(outcome.json()["experiments"]["extrapolation"]["curves"].size() == 9);
  CHECK_THAT(outcome.err, Catch::Contains("Hermite") && Catch::Contains("jumps by"));
  CHECK_THAT(shop.files(), Catch::Contains("out/report.html"));
}

TEST_CASE("experiments that cannot be run", "[laboratory]") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  check_refused(shop, "reproduce", {"WHAT"});
  check_refused(shop, "reproduce timming beam.toml -o out", {"did you mean 'timing'"});
  check_refused(shop, "reproduce speed --set state_space.spacing=0.012 -o out", {"state_space.spacing", "predecessor"});
  check_refused(shop, "reproduce speed --travel nan -o out", {"--travel"});
  check_refused(shop, "reproduce speed --workers 2 4 4 -o out", {"--workers", "4 twice"});
  check_refused(shop, "reproduce speed --set session.workers=3 -o out", {"session.workers"});
  check_refused(shop, "reproduce speed --set session.cost=bogus -o out", {"cost bogus"});
  check_refused(shop, "reproduce all --set session.policy=fifo -o out", {"session.policy"});
  check_refused(shop, "reproduce timing absent.toml -o out", {"absent.toml"});
  check_refused(shop, "reproduce energy beam.toml --gap 4 -o out", {"--gap", "energy", "extrapolation"});
  check_refused(shop, "reproduce damping beam.toml --rounds 4 -o out", {"--rounds", "damping", "timing"});
  check_refused(shop, "reproduce extrapolation beam.toml --workers 4 -o out", {"--workers", "speed"});
  check_refused(shop, "reproduce timing beam.toml", {"--output"});
  check_refused(shop, "reproduce timing beam.toml -o beam.toml/out", {"beam.toml/out"});
  check_refused(shop, "reproduce damping beam.toml --interval 0 -o out", {"--interval"});
  check_refused(shop, "reproduce damping beam.toml --depth 2 -o out", {"--depth"});
  check_refused(shop, "bench switch absent.toml", {"absent.toml"});
  check_refused(shop, "classify --calibrate absent.toml", {"absent.toml"});
  check_refused(shop, "classify --calibrate beam.toml --grid 0.01", {"--calibrate"});
  check_refused(shop, "classify absent.states --calibrate beam.toml", {"absent.states"});
}

TEST_CASE("bench switch: bounds hold and the latest model wins", "[laboratory]") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const Workshop::Outcome outcome = shop.forefeel("bench switch beam.toml --json");
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  const nlohmann::json found = outcome.json();
  REQUIRE(found["rows"].size() == 12);
  for (const auto& row : found["rows"]) {
    for (const char* key : {"name", "baseline", "ratio", "ours_us", "baseline_us", "error", "n", "k", "scene",
                            "law", "elements", "threads", "tolerance"})
      CHECK(row.contains(key));
    CHECK(row["latest_wins"] == true);
    CHECK(row["delay"]["within_bound"] == true);
    // A window of w ms holds w frames; changes of opposite signs may cancel in a longer one.
    const double jump = row["max_jump"];
    CHECK(row["drift"]["ms50"].get<double>() > 0);
    CHECK(row["drift"]["ms50"].get<double>() <= 50 * jump);
    CHECK(row["drift"]["ms300"].get<double>() <= 300 * jump);
    if (row["rule"] == "none")
      CHECK(row["delay"]["max_ms"] == 0.0);
    else
      CHECK(row["frames_over_jnd"] == 0);
  }
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

TEST_CASE("labels are calibrated on a field that is known", "[laboratory]") {
  CalibrationOptions options;
  options.space.spacing = 0.006;
  options.space.box = {Vec3::Constant(-0.03), Vec3::Constant(0.03)};
  options.inward = Vec3(0.2, 0.1, 0.9);
  std::vector<State> pool, truth;
  for (const Vec3& x : lattice(options.space.box, 0.006)) pool.push_back(field_state(x));
  for (int i = 0; i < 24; ++i)
    truth.push_back(
        field_state(0.028 * Vec3(std::sin(2.1 * i), std::sin(3.7 * i + 1), std::sin(5.3 * i + 2))));
  options.threads = 1;
  const Calibration found = calibrate(pool, truth, options);
  REQUIRE(found.kinds.size() == 5);
  REQUIRE(found.table.size() == 20);
  for (const std::size_t positions : found.positions) CHECK(positions > 0);  // every label is met
  for (std::size_t kind = 0; kind < 5; ++kind) {
    CAPTURE(found.kinds[kind].name);
    const auto* cells = &found.table[4 * kind];
    std::size_t count = 0;
    for (int label = 0; label < 4; ++label) {
      count += cells[label].count;
      CHECK(cells[label].low <= cells[label].share);
      CHECK(cells[label].share <= cells[label].high);
      CHECK(cells[label].p50 <= cells[label].p95);
    }
    CHECK(count == truth.size() * found.sets.size());
    CHECK(cells[0].p95 < cells[3].p95);  // safe is safer than blank
    CHECK(cells[0].over == 0);
    CHECK(found.ranks[kind].label > 0.3);
    CHECK(found.ranks[kind].power > 0.3);
  }
  options.threads = 3;
  const Calibration again = calibrate(pool, truth, options);
  for (std::size_t i = 0; i < found.samples.size(); ++i) {
    CHECK(again.samples[i].error == found.samples[i].error);
    CHECK((again.samples[i].power == found.samples[i].power));
  }
}

TEST_CASE("calibration as a command", "[laboratory]") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const Workshop::Outcome outcome = shop.forefeel(
      "classify --calibrate beam.toml --set 'state_space.box=[[-0.012,-0.012,-0.012],[0.012,0.012,0.012]]' "
      "--json -o out");
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  const nlohmann::json found = outcome.json();
  CHECK(found["table"].size() == 20);
  CHECK(found["ranks"].size() == 5);
  for (const char* file : {"calibration.csv", "ranks.csv", "samples.csv", "report.html"})
    CHECK_THAT(shop.files(), Catch::Contains(std::string("out/") + file));
  REQUIRE(shop.forefeel("generate beam.toml -o soft.states --quiet --set material.young=4000").code == 0);
  check_refused(shop, "classify soft.states --calibrate beam.toml -o other", {"soft.states", "material"});
}

TEST_CASE("spacing = auto makes safe mean an error below the tolerance", "[laboratory]") {
  const Workshop shop;
  const std::string scene = R"([body]
phantom = "beam"
elements = 240
[material]
law = "neo-hookean"
young = 5000.0
poisson = 0.3
[state_space]
spacing = "auto"
box = [[-0.016, -0.016, -0.016], [0.016, 0.016, 0.016]]
)";
  shop.write("beam.toml", scene);
  const Workshop::Outcome first = shop.forefeel("generate beam.toml --json -o a.states");
  INFO(first.err);
  REQUIRE(first.code == 0);
  const nlohmann::json a = first.json();
  REQUIRE(a["spacing_auto"]["holds"] == true);
  CHECK(a["spacing"] == a["spacing_auto"]["spacing"]);
  CHECK(a["spacing_auto"]["max"].get<double>() <= 0.07);
  CHECK(a["spacing_auto"]["safe"].get<int>() >= 8);
  // Kept, whatever the threads, and the same without what was kept.
  CHECK(shop.forefeel("generate beam.toml --threads 1 --json -o b.states").json()["spacing"] == a["spacing"]);
  CHECK(shop.shell("export XDG_CACHE_HOME=$PWD/other; '" FOREFEEL_BINARY_DIR
                   "/apps/forefeel' generate beam.toml --threads 1 --json -o c.states")
            .json()["spacing_auto"] == a["spacing_auto"]);
  // A finer tolerance never takes a coarser lattice.
  const nlohmann::json fine =
      shop.forefeel("generate beam.toml --json --set state_space.tolerance=0.0005 -o d.states").json();
  CHECK(fine["spacing"].get<double>() < a["spacing"].get<double>());
  const Workshop::Outcome info = shop.forefeel("info a.states");
  CHECK_THAT(info.out, Catch::Contains("spacing \"auto\""));
  CHECK(shop.forefeel("solve beam.toml --at=0,0,0.001").code == 0);
  const Workshop::Outcome session =
      shop.forefeel("session beam.toml --clock virtual --seconds 0.2 --json -o run");
  INFO(session.err);
  REQUIRE(session.code == 0);
  CHECK(session.json()["spacing"] == a["spacing"]);
  check_refused(shop, "solve beam.toml --at=0,0,0 --set state_space.spacing=automatic", {"auto"});
  check_refused(shop, "solve beam.toml --at=0,0,0 --set state_space.tolerance=0", {"tolerance", "above 0"});
}
