// The first lines that commands print: outcomes, motions that no method can follow, and the force limit in the report.

#include "tests/support/executable.hpp"

namespace {

// A beam whose law has no barrier against inversion, pressed together.
std::string soft_scene() {
  return R"([body]
phantom = "beam"
elements = 240
[material]
law = "st-venant-kirchhoff"
young = 5000.0
poisson = 0.3
[state_space]
spacing = 0.03
box = [[-0.09, -0.001, -0.001], [0, 0.001, 0.001]]
)";
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

}  // namespace

TEST_CASE("an equilibrium with inverted elements does not count as converged, in solve, generate and info") {
  const Workshop shop;
  shop.write("soft.toml", soft_scene());
  const Workshop::Outcome solved = shop.forefeel("solve soft.toml --at=-0.09,0,0 --at=-0.001,0,0 --json");
  CHECK(solved.code == 1);
  const auto states = solved.json()["states"];
  REQUIRE(states[0]["min_jacobian"] <= 0);
  CHECK(states[0]["converged"] == false);
  CHECK(states[0]["status"] == "inverted");
  CHECK(states[0]["force"][0].is_number());
  CHECK(states[1]["converged"] == true);
  CHECK_THAT(solved.err, Contains("1 of 2 states have inverted elements"));

  const Workshop::Outcome made = shop.forefeel("generate soft.toml -o s.states --json");
  const auto report = made.json();
  CHECK(report["states"] == 4);
  CHECK(report["inverted"].get<int>() > 0);
  CHECK(report["solved"].get<int>() + report["inverted"].get<int>() == 4);
  CHECK_THAT(made.err, Contains("with inverted elements"));
  const auto info = shop.json("info s.states");
  CHECK(info["inverted"] == report["inverted"]);
  CHECK(info["by_status"]["inverted"] == report["inverted"]);
  CHECK(shop.json("generate soft.toml -o s.states")["inverted"] == report["inverted"]);
}

TEST_CASE("a session whose motion starts pressed in and leaves the box says so in its first lines") {
  const BeamShop shop;
  std::string rows = "t,x,y,z\n";
  for (int k = 0; k <= 100; ++k)
    rows += std::to_string(0.01 * k) + ",0,0," + std::to_string(k < 50 ? 0.004 : 0.004 + 0.0001 * (k - 50)) +
            "\n";
  shop.write("pressed.csv", rows);
  const std::string command =
      "session beam.toml --clock virtual --cost constant:0.05 --device trace:pressed.csv -o run --set "
      "material.young=2e6";
  const auto run = shop.run(command);
  CHECK_THAT(first_line(run.out), Catch::StartsWith("attention: the motion starts pressed in"));
  CHECK_THAT(run.out, Contains("of the time was outside the box"));
  const auto summary = json::parse(shop.read("run/summary.json"));
  REQUIRE(summary["attention"].size() >= 2);
  CHECK(summary["start"]["reference"].get<double>() > 0.05);
  CHECK(summary["start"]["rendered"] < 0.002);  // it fades in from zero
  CHECK(summary["time_outside"] == Approx(0.5).margin(0.02));
  const std::string report = shop.read("run/report.html");
  const std::size_t said = report.find("starts pressed in"), tiles = report.find("class=\"tile\"");
  REQUIRE(said != std::string::npos);
  CHECK(said < tiles);
}

TEST_CASE("info of a run's folder says what was run, what came of it and what to look at") {
  const BeamShop shop;
  shop.run("session beam.toml --clock virtual --seconds 0.2 --cost constant:0.02 -o run --quiet");
  const json said = shop.json("info run"), summary = json::parse(shop.read("run/summary.json"));
  CHECK(said["kind"] == "run");
  CHECK(said["frames"] == summary["frames"]);
  CHECK(said["error"]["p95"] == summary["error"]["p95"]);
  const auto told = shop.run("info run/");
  for (const std::string word :
       {"forefeel session beam.toml", "frames; 0 states at the start", "report.html", "forefeel show run"})
    CHECK_THAT(told.out, Contains(word));
  CHECK(shop.run("show run").code == 0);
  CHECK_THAT(shop.run("session beam.toml --clock virtual --seconds 0.2 --cost constant:0.02 -o run").out,
             Contains("run: the report, tables and shapes of an earlier run are replaced"));
  CHECK(shop.has("run/show.html"));
  CHECK(shop.forefeel("show beam.toml").code == 2);
  CHECK(shop.forefeel("info .").code == 2);
}

TEST_CASE("clamped frames are said first, the report draws the limit, and plots show what the errors judge") {
  const BeamShop shop("[session.limits]\nforce = 0.02\n");
  const auto run = shop.run(
      "session beam.toml --clock virtual --seconds 1 --cost constant:0.02 --device path:press,speed=0.02 "
      "--set "
      "session.discretisation_error=false -o run");
  CHECK_THAT(first_line(run.out),
             Catch::StartsWith("attention: ") && Contains("clamped at the force limit of 0.02 N"));
  const auto summary = json::parse(shop.read("run/summary.json"));
  CHECK(summary["safety"]["clamped_share"].get<double>() > 0.05);
  CHECK(summary["safety"]["force_limit"] == 0.02);
  const std::string report = shop.read("run/report.html");
  if (report.find("<svg") != std::string::npos) {
    CHECK_THAT(report, Contains("force limit 0.02 N"));
    CHECK_THAT(report, Contains("sent to the device"));
  }
}

TEST_CASE("a study says each device's length and its verdict in a sentence") {
  const BeamShop shop("[session]\nseconds = 0.5\ncost = \"constant:0.01\"\n");
  shop.write("short.csv", "t,x,y,z\n0,0,0,0\n0.1,0,0.002,0\n0.2,0,0.003,0.002\n");
  shop.write("study.toml",
             "scene = \"beam.toml\"\nseeds = [1, 2]\n[vary]\npolicy = [\"nearest\", \"coverage\"]\n"
             "device = [\"path:circle,speed=0.05\", \"trace:short.csv\"]\n");
  const auto run = shop.run("study study.toml -o out --json");
  const auto document = run.json();
  CHECK_THAT(document["verdict"].get<std::string>(), Catch::StartsWith("No winner: "));
  REQUIRE(document["devices"].size() == 2);
  CHECK(document["devices"][0]["motion_seconds"].is_null());
  CHECK(document["devices"][0]["seconds"] == 0.5);
  CHECK(document["devices"][1]["motion_seconds"] == Approx(0.2));
  CHECK(document["devices"][1]["seconds"] == Approx(0.201));
  for (const char* key : {"clamped_share", "slewed_share", "time_outside", "busy_share", "generated_J"})
    CHECK(document["devices"][0][key].is_number());
  CHECK_THAT(run.err, Contains("No winner: ", "trace:short.csv | 0.2 s"));
  CHECK_THAT(first_line(shop.read("out/cells.csv")), Contains("motion_seconds"));
  CHECK_THAT(shop.read("out/report.html"), Contains("No winner: ", "<h2>Devices</h2>"));
}
