// forefeel-bench: what it prints, what it refuses, and that its baselines find the same forces.

#include "apps/bench/bench.hpp"
#include "tests/support/executable.hpp"
#include "tests/support/json_keys.hpp"

namespace {

json run_bench(const Workshop& shop, const std::string& arguments) {
  const Workshop::Outcome outcome = shop.forefeel_bench(arguments + " --json");
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  return outcome.json();
}

void check_bench_refused(const Workshop& shop, const std::string& arguments,
                         const std::vector<std::string>& mentions) {
  const std::string before = shop.files();
  check_refused(shop.forefeel_bench(arguments), arguments, mentions);
  CHECK(shop.files() == before);
}

}  // namespace

TEST_CASE("bench switch: bounds hold and the latest model wins",
          "[bench]" SLOW("runs forefeel-bench, which only run.sh all builds")) {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const Workshop::Outcome outcome = shop.forefeel_bench("switch beam.toml --json");
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  const json found = outcome.json();
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

TEST_CASE("bench approx: inside is inside the lattice, and what is left out is said",
          "[bench]" SLOW("runs forefeel-bench, which only run.sh all builds")) {
  const Workshop shop;
  // f = -K x: trilinear cells are exact inside the lattice and wrong beyond it, where the force is held constant. The
  // box extends 3 mm beyond the lattice of 6 mm.
  shop.write("beam.toml", beam_scene());
  const Workshop::Outcome outcome = shop.forefeel_bench(
      "approx beam.toml --json --set 'material.law=\"linear\"' --set state_space.spacing=0.006 "
      "--set 'state_space.box=[[-0.009,-0.009,-0.009],[0.015,0.009,0.009]]' -o out");
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  const json found = outcome.json();
  bool trilinear = false;
  for (const auto& method : found["methods"]) {
    if (method["method"] == "trilinear" || method["method"] == "tricubic") {
      trilinear = true;
      CHECK(method["error"]["max"].get<double>() < 1e-6);
    }
    CHECK(method["n"].get<int>() <= 36);
  }
  CHECK(trilinear);
  REQUIRE(!found["rows"].empty());
  std::vector<int> scalar;
  for (const auto& row : found["rows"])
    if (row["name"] == "evaluate hermite-r5" && row["baseline"] == "scalar -O2") {
      scalar.push_back(row["n"]);
      CHECK(row["ratio"].get<double>() > 0);
    }
  CHECK(scalar == std::vector<int>{8});  // 25 + 20 are more than the 36 states
  const std::string notes = found["notes"].dump();
  CHECK_THAT(
      notes,
      Contains("r, r3, r5 with n = 100: needs 120 states (20 to replace), the lattice has 36, left out",
               "no multiple of the spacing", "hermite-r3, hermite-r5 with n = 25"));
  CHECK_THAT(outcome.err, Contains("needs 120 states") && !Contains("gives another force"));
  CHECK_THAT(shop.files(), Contains("out/approx.csv"));
  // Eight states are too few to measure a model. All other results are there, and the answer is incomplete.
  const Workshop::Outcome few = shop.forefeel_bench(
      "approx beam.toml --json --set 'material.law=\"linear\"' --set state_space.spacing=0.006 "
      "--set 'state_space.box=[[0,0,0],[0.006,0.006,0.006]]'");
  INFO(few.err);
  CHECK(few.code == 1);
  CHECK(few.json()["rows"].empty());
  CHECK_THAT(few.err, Contains("no row could be measured"));
}

TEST_CASE("bench solver: a shrunk lattice and a single state, where all solvers find the same force",
          "[bench]" SLOW("runs forefeel-bench, which only run.sh all builds")) {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const json few = run_bench(shop, "solver beam.toml --set state_space.spacing=0.002 --states 30");
  REQUIRE(few["rows"].size() == 2);
  CHECK(few["rows"][0]["n"] <= 30);
  CHECK(few["rows"][0]["n"] > 1);
  CHECK(few["states_of_the_scene"] > few["rows"][0]["n"]);
  CHECK(few["rows"][0]["error"]["max"] < 1e-6);
  const json one = run_bench(shop, "solver beam.toml --states 1");
  REQUIRE(one["rows"].size() == 2);
  for (const json& row : one["rows"]) {
    for (const char* key :
         {"name", "baseline", "ratio", "ours_us", "baseline_us", "ours_bytes", "baseline_bytes"})
      CHECK(row.contains(key));
    CHECK(row["error"]["max"] < 1e-5);
    CHECK(row["ours_bytes"] > 0);
  }
}

TEST_CASE("bench scale: shares, bounds and forces hold",
          "[bench]" SLOW("runs forefeel-bench, which only run.sh all builds")) {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const Workshop::Outcome outcome =
      shop.forefeel_bench("scale beam.toml --threads 2 --set state_space.spacing=0.003 --json -o out");
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  const json found = outcome.json();
  CHECK_THAT(outcome.err, Contains("threads"));
  CHECK_THAT(shop.files(), Contains("out/scale.svg"));
  REQUIRE(found["rows"].size() ==
          10);  // generate, classify and evaluate of two sizes, each on 1 and 2 threads
  for (const json& row : found["rows"]) {
    INFO(row.dump());
    CHECK(row["per_s"].get<double>() > 0);
    CHECK(row["serial_share"].get<double>() >= 0);
    CHECK(row["serial_share"].get<double>() <= 1);
    if (row["name"].get<std::string>().starts_with("generate")) {
      CHECK(row["parallel"]["work_s"].get<double>() >= row["parallel"]["path_s"].get<double>());
      CHECK(row["parallel"]["path_s"].get<double>() > 0);
      CHECK(row["error"]["max"] == 0.0);  // the same states on two threads
    } else if (found["scipy"] == true) {
      CHECK(row["error"]["max"].get<double>() < 1e-8);
      CHECK(row["ratio"].get<double>() > 0);
    } else {
      CHECK(row["ratio"].is_null());
    }
  }
}

TEST_CASE("the help of forefeel-bench lists the keys of solver of one state --json",
          "[bench]" SLOW("runs forefeel-bench, which only run.sh all builds")) {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  compare_keys(declared_bench_json(), "bench_solver.json", {run_bench(shop, "solver beam.toml --states 1")},
               {"failed", "states_of_the_scene", "speedup_over_one_thread", "errors_drawn", "baseline_states",
                "baseline_iterations", "baseline_failed", "multivalued", "off_branch", "peak_bytes",
                "bytes_per_thread", "cholmod_factor_bytes"});
  const Workshop::Outcome help = shop.forefeel_bench("help outputs bench_solver.json");
  CHECK(help.code == 0);
  CHECK_THAT(help.out, Contains("states_of_the_scene"));
}

TEST_CASE("forefeel-bench refuses what a bench does not take",
          "[bench]" SLOW("runs forefeel-bench, which only run.sh all builds")) {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  shop.write("anywhere.toml",
             "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"neo-hookean\"\nyoung = 5000.0\n"
             "poisson = 0.3\n[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\n");
  shop.write("taken.csv", "x\n");
  check_bench_refused(shop, "solvr", {"'solvr'", "did you mean 'solver'", "approx, solver, coverage"});
  CHECK_THAT(shop.forefeel_bench("").out, Contains("approx"));
  check_bench_refused(shop, "switch absent.toml", {"absent.toml"});
  check_bench_refused(shop, "approx -o taken.csv", {"taken.csv", "is a file", "expected a folder"});
  check_bench_refused(shop, "coverage --set material.poisson=0.4", {"--set", "coverage"});
  check_bench_refused(shop, "coverage --states 5", {"--states"});
  for (const std::string bench : {"approx", "solver", "switch"})
    check_bench_refused(shop, bench + " --set material.poison=0.4",
                        {"--set material.poison", "material.poisson"});
  check_bench_refused(shop, "loop beam.toml --seconds 4 --blocks 3", {"--seconds"});
  check_bench_refused(shop, "loop beam.toml --blocks 0", {"--blocks"});
  check_bench_refused(shop, "loop beam.toml -o out", {"-o"});
  check_bench_refused(shop, "switch beam.toml --seconds 4", {"--seconds"});
  check_bench_refused(shop, "switch beam.toml --blocks 4", {"--blocks"});
  check_bench_refused(shop, "solver anywhere.toml", {"anywhere.toml:", "contact.anywhere", "solve --site"});
}

TEST_CASE("the paper's times: ours are a thousandth of them, by the script that compares them",
          "[bench]" SLOW("runs forefeel-bench, which only run.sh all builds")) {
  const Workshop shop;
  const Workshop::Outcome outcome =
      shop.shell("python3 '" + (source_folder() / "apps/paper/timing.py").string() +
                 "' --quick -o out --forefeel '" + executable() + "'");
  INFO(outcome.out << outcome.err);
  REQUIRE(outcome.code == 0);
  const json rows = json::parse(shop.read("out/summary.json"));
  REQUIRE(rows.size() == 10);
  for (const json& row : rows)
    if (row["holds"] == true && row["us"].is_array())
      CHECK(row["us"][4].get<double>() < 1e-3 * row["us"][0].get<double>());
}
