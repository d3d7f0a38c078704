// The JSON of every command has the documented keys.

#include <fmt/format.h>

#include "tests/apps/contract.hpp"

TEST_CASE("an interrupt before anything began is said, and leaves nothing", "[contract]") {
  const Workshop shop;
  // Long solves, so that the spacing is still being chosen when the signal comes.
  shop.write("beam.toml", beam_scene());
  const std::string automatic =
      " --set state_space.spacing=auto --set session.error_floor=1e-6 --set state_space.tolerance=1e-9";
  const Workshop::Outcome measured =
      run_interrupted(shop, "generate beam.toml -o s.states" + automatic, takes_signals, 0.2);
  CHECK(measured.error_lines() == 1);
  CHECK_THAT(measured.err, Contains("interrupted", "nothing was written"));
  CHECK_FALSE(fs::exists(shop.path() / "s.states"));
}

TEST_CASE("solve", "[contract]") {
  const BeamShop shop;
  const json document = shop.json("solve beam.toml --at=0,0,0 --at=0.001,-0.002,0.001 -o out.csv");
  REQUIRE(document["states"].size() == 2);
  for (const json& state : document["states"]) {
    check_keys(state, {"at", "force", "stiffness", "energy", "converged", "iterations", "residual", "seconds",
                       "min_jacobian", "multivalued", "warnings"});
    CHECK(state["force"].size() == 3);
    CHECK(state["stiffness"].size() == 3);
    CHECK(state["stiffness"][0].size() == 3);
    CHECK(state["converged"] == true);
    CHECK(state["warnings"].is_array());
  }
  const json& pushed = document["states"][1];
  double work = 0;  // the force opposes the displacement x
  for (int i = 0; i < 3; ++i) work += pushed["force"][i].get<double>() * pushed["at"][i].get<double>();
  CHECK(work < 0);
  CHECK(pushed["energy"].get<double>() > 0);
  CHECK_THAT(shop.files(), Contains("out.csv"));
}

TEST_CASE("generate that was killed goes on from what is on disk and ends with the states of a whole run") {
  const BeamShop shop;
  const std::string fine = " --set state_space.spacing=0.0003 --threads 1";  // 19683 states
  shop.shell(executable() + " generate beam.toml -o cut.states --quiet" + fine + " & p=$!; " +
             wait_until(is_larger("cut.states-wal", 400000)) + "kill -9 $p; wait $p");
  const json resumed = shop.json("generate beam.toml -o cut.states" + fine);
  CHECK(resumed["resumed"].get<int>() > 0);
  CHECK(resumed["solved"].get<int>() > 0);
  CHECK(resumed["states"] == 19683);
  shop.run("generate beam.toml -o whole.states --quiet" + fine);
  for (const std::string file : {"cut", "whole"}) {
    shop.run("export " + file + ".states -o " + file + ".csv --quiet");
    shop.shell("sort " + file + ".csv > " + file + ".sorted");
  }
  CHECK(shop.same("cut.sorted", "whole.sorted"));
}

TEST_CASE("solve of many positions that was killed goes on from what is kept and ends with the same forces") {
  const BeamShop shop;
  std::string points = "x,y,z\n";
  for (int i = 0; i < 3000; ++i)
    points += fmt::format("{},{},{}\n", 1e-5 * (i % 100), 2e-5 * (i / 100), 3e-5 * (i % 7));
  shop.write("points.csv", points);
  const std::string solve = "solve beam.toml --points points.csv --threads 1 -o ";
  shop.shell(executable() + " " + solve + "cut.csv --quiet & p=$!; " +
             wait_until(is_larger("\"$XDG_CACHE_HOME\"/forefeel/*-solves.states-wal", 100000)) +
             "kill -9 $p; wait $p");
  REQUIRE_FALSE(shop.has("cut.csv"));
  CHECK_THAT(shop.run(solve + "resumed.csv").out, Contains("of an earlier run, ended early, are kept"));
  shop.run(solve + "whole.csv --quiet");
  CHECK(shop.same("resumed.csv", "whole.csv"));
  CHECK(shop.shell("ls \"$XDG_CACHE_HOME\"/forefeel").out.find("solves") == std::string::npos);
}

TEST_CASE("generate: a box without a position of the lattice is refused", "[contract]") {
  const BeamShop shop;
  check_refused(
      shop,
      "generate beam.toml -o s.states --set 'state_space.box=[[0.001,0.001,0.001],[0.003,0.003,0.003]]'",
      {"--set state_space.box: holds no position of the lattice of 0.004 m",
       "a smaller state_space.spacing"});
  check_refused(
      shop, "generate beam.toml -o s.states --set 'state_space.box=[[0.001,-0.01,-0.01],[0.003,0.01,0.01]]'",
      {"holds no position"});
  shop.run(
      "generate beam.toml -o s.states --quiet --set "
      "'state_space.box=[[0.001,0.001,0.001],[0.004,0.004,0.004]]'");
}

TEST_CASE("generate --error says where only a smaller spacing helps", "[contract]") {
  const BeamShop shop;  // 27 lattice states
  const Workshop::Outcome outcome = shop.forefeel("generate beam.toml --error 1e-7 -o s.states --json");
  CHECK(outcome.code == 1);
  CHECK(outcome.json()["states"] == 27);
  CHECK(outcome.json()["most_states"] == 27);
  // What was done, the estimate, the mesh's own error, the warning, how to look at it.
  CHECK(outcome.error_lines() == 5);
  CHECK_THAT(outcome.err, Contains("discretisation error of the mesh"));
  CHECK_THAT(outcome.err, Contains("27 states, as many as the lattice of 0.004 m has positions in the box",
                                   "; reduce the spacing"));
  // At least nine are tried on any lattice.
  const Workshop::Outcome coarse =
      shop.forefeel("generate beam.toml --error 1e-9 -o c.states --quiet --set state_space.spacing=0.05");
  CHECK(coarse.code == 1);
  CHECK_THAT(
      coarse.err,
      Contains("9 states, the fewest that are tried, for the lattice of 0.05 m has 1 position in the box"));
}

TEST_CASE("mesh", "[contract]") {
  const Workshop shop;
  const json document = shop.json("mesh --phantom ball --elements 400 -o ball.msh");
  check_keys(document, {"nodes", "elements", "volume", "min_dihedral_deg", "max_dihedral_deg", "hausdorff",
                        "repaired"});
  CHECK(document["elements"].get<int>() >= 380);
  CHECK(document["elements"].get<int>() <= 420);
  CHECK(document["repaired"].is_object());
  CHECK_THAT(shop.files(), Contains("ball.msh"));
}

TEST_CASE("generate, export, info, classify and evaluate", "[contract]") {
  const BeamShop shop;
  const std::vector<std::string> keys{
      "states", "solved", "failed", "resumed", "seconds", "states_per_second", "threads", "error_estimate"};
  const json first = shop.json("generate beam.toml -o beam.states");
  check_keys(first, keys);
  CHECK(first["states"] == 27);
  CHECK(first["interrupted"] == false);
  const json again = shop.json("generate beam.toml -o beam.states");
  CHECK(again["resumed"] == 27);
  CHECK(again["solved"] == 0);

  CHECK(shop.json("info beam.states").is_object());
  shop.run("export beam.states -o beam.csv --quiet");
  shop.run("import beam.csv -o copy.states --spacing 0.004 --quiet");

  shop.write("points.csv", "x,y,z\n0,0,0\n0.001,0.002,-0.001\n0.5,0,0\n");
  const json labels = shop.json("classify beam.states --points points.csv");
  check_keys(labels, {"labels", "spread", "alpha", "delta", "gamma_deg", "volume.safe", "volume.sparse",
                      "volume.gap", "volume.blank", "components", "fill_distance", "largest_hole.radius",
                      "largest_hole.centre", "seconds", "peak_bytes"});
  CHECK(labels["labels"] == json({"safe", "safe", "blank"}));
  CHECK(labels["spread"][2].is_null());  // infinite outside the hull

  const json forces =
      shop.json("evaluate beam.states --points points.csv --kernel cubic --data force --neighbours 27");
  check_keys(forces, {"forces", "labels", "fit_us", "evaluate_ns"});
  REQUIRE(forces["forces"].size() == 3);
  for (const json& value : forces["forces"][2]) CHECK(value.is_number());  // bounded at any distance
}
