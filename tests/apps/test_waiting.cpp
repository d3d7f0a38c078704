// Waiting times: a command computes only what it needs, progress lines show the current step, and results are cached.

#include <fmt/format.h>

#include "apps/console/console.hpp"
#include "tests/support/executable.hpp"

namespace {

// What the cache of a workshop holds, one name a line.
std::string cached(const Workshop& shop) {
  return shop.shell("ls ../cache/forefeel 2>/dev/null || true").out;
}

// What a command prints to a terminal.
std::string on_terminal(const Workshop& shop, const std::string& arguments) {
  return shop.shell("script -qefc \"" + executable() + " " + arguments + "\" /dev/null").out;
}

}  // namespace

TEST_CASE("a progress line gives the time left of a share, and without a share the time so far") {
  CHECK(progress_line("solve", 0.25, "1 of 4 states", 60) == "solve  25 %  1 of 4 states, 3:00 left");
  CHECK(progress_line("generate: placing states", -1, "9 of at most 343", 71) ==
        "generate: placing states  9 of at most 343, 1:11 so far");
  CHECK(progress_line("solve", 0, "0 of 4 states", 5) == "solve   0 %  0 of 4 states");
  CHECK_THAT(progress_line("solve", 0.5, "", 7200), Catch::EndsWith("2:00:00 left"));
}

TEST_CASE("what an earlier run did does not count in the time left") {
  CHECK(progress_line("sites", 0.75, "", 10, 0.5) == "sites  75 %  0:10 left");
  CHECK(std::isnan(seconds_left(0.5, 0.5, 10)));
  CHECK(std::isnan(seconds_left(1, 0, 10)));
  CHECK(seconds_left(0.5, 0, 10) == 10);
  CHECK(std::isnan(seconds_left(0.04, 0, 10)));
  CHECK(seconds_left(0.04, 0, 25) == Approx(600));
}

TEST_CASE(
    "without a terminal a line comes every 10 s, and early where a first piece shows that it takes long") {
  const double not_known = seconds_left(0.001, 0, 3);
  CHECK_FALSE(line_is_due(9, 9, 9, true));
  CHECK(line_is_due(9, 10, 10, true));
  CHECK(line_is_due(not_known, 10, 10, true));
  CHECK_FALSE(line_is_due(100, 15, 5, false));
  CHECK(line_is_due(18, 2, 2, true));
  CHECK_FALSE(line_is_due(18, 1.9, 1.9, true));
  CHECK_FALSE(line_is_due(not_known, 3, 3, true));
}

TEST_CASE("what takes long says how long, also where stderr is a pipe", "[waiting]" SLOW("runs for 30 s")) {
  const Workshop shop;
  shop.write(
      "slab.toml",
      "[body]\nphantom = \"slab\"\nelements = 30000\n[material]\nlaw = \"neo-hookean\"\nyoung = 5000.0\n"
      "poisson = 0.3\n[clamp]\ngroup = \"clamp\"\n[contact]\npad = 400.0\nradius = 0.012\n");
  std::string places;
  for (int i = 0; i < 40; ++i) places += fmt::format(" --at=0,0,-{}", 0.02 + 1e-4 * i);
  const auto told = shop.shell("timeout 30 '" + executable() + "' solve slab.toml --threads 1" + places +
                               " 2>&1 >/dev/null");
  CHECK_THAT(told.out, Contains("solve ") && Contains(" of 40 states, ") && Contains(" left\n"));
  CHECK_THAT(told.out, !Contains("\r"));
}

TEST_CASE("solve measures no spacing, and gives the same forces as with a spacing of its own") {
  const BeamShop shop;
  const std::string at = "solve beam.toml --at=0.002,0,0.003 --json";
  const auto automatic = shop.run(at + " --set 'state_space.spacing=\"auto\"'");
  CHECK_THAT(automatic.err, Contains("is not measured"));
  CHECK_THAT(cached(shop), !Contains("spacing.json"));
  const auto a = automatic.json()["states"][0]["force"], b = shop.forefeel(at).json()["states"][0]["force"];
  for (int i = 0; i < 3; ++i) CHECK(a[i] == Approx(b[i].get<double>()).epsilon(1e-8));
}

TEST_CASE("classify with a spacing of its own measures none") {
  const BeamShop shop;
  shop.run("generate beam.toml -o s.states --quiet");
  shop.run(
      "classify s.states --scene beam.toml --spacing 0.004 --quiet --set "
      "'state_space.spacing=\"auto\"'");
  CHECK_THAT(cached(shop), !Contains("spacing.json"));
}

TEST_CASE(
    "on a terminal, generate --error says which phase goes on and promises no time that it cannot know") {
  if (!has_command("script")) return skip("script is not installed");
  const BeamShop shop;
  const std::string seen = on_terminal(shop, "generate beam.toml --error 0.001 -o s.states");
  CHECK_THAT(seen, Contains("generate: placing states  ", "so far", "generate: checking the error ",
                            "tight solves"));
  const std::size_t placing = seen.find("placing states  ");
  CHECK_THAT(seen.substr(placing, seen.find('\r', placing) - placing), !Contains("left"));
}

TEST_CASE("on a terminal, mesh says what it does") {
  if (!has_command("script")) return skip("script is not installed");
  const Workshop shop;
  CHECK_THAT(on_terminal(shop, "mesh --phantom ball --elements 300 -o ball.msh"),
             Contains("mesh  making the phantom ball, 0:00 so far"));
  shop.write("cube.off",
             "OFF\n8 12 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n3 0 2 1\n3 1 2 3\n"
             "3 4 5 6\n3 5 7 6\n3 0 1 4\n3 1 5 4\n3 2 6 3\n3 3 6 7\n3 0 4 2\n3 2 4 6\n3 1 3 5\n3 3 7 5\n");
  CHECK_THAT(on_terminal(shop, "mesh cube.off --elements 4000 -o cube.msh"),
             Contains("surface 1 of at most 14", "tried"));
}

TEST_CASE("on a terminal, measuring a spacing shows which one is tried") {
  if (!has_command("script")) return skip("script is not installed");
  const BeamShop shop;
  CHECK_THAT(on_terminal(shop, "generate beam.toml -o s.states --set state_space.spacing=auto"),
             Contains("spacing \"auto\"  try 1 of at most 8"));
}

TEST_CASE("the cache says its place and size, and is emptied without touching what is not its own") {
  const BeamShop shop;
  shop.run("session beam.toml --clock virtual --seconds 0.2 --cost constant:0.02 -o run --quiet");
  shop.run(
      "session beam.toml --clock virtual --seconds 0.1 --shape-rate 10 -o shapes --quiet "
      "--set state_space.jet=3");
  CHECK_THAT(cached(shop), Contains("-displacements-jet3.states"));
  shop.shell("echo mine > ../cache/forefeel/notes.txt");
  const auto full = shop.json("cache");
  CHECK(full["files"].get<int>() >= 2);
  CHECK(full["bytes"].get<long>() > 1000);
  CHECK(full["foreign"] == 1);
  CHECK_THAT(full["place"].get<std::string>(), Catch::EndsWith("/cache/forefeel"));
  CHECK_THAT(shop.forefeel("cache").out, Contains("/cache/forefeel: ", " files, "));

  const auto emptied = shop.json("cache --empty");
  CHECK(emptied["removed"]["files"] == full["files"]);
  CHECK(emptied["removed"]["bytes"] == full["bytes"]);
  CHECK(emptied["files"] == 0);
  CHECK(cached(shop) == "notes.txt\n");
  shop.run("session beam.toml --clock virtual --seconds 0.2 --cost constant:0.02 -o again --quiet");
  CHECK(shop.json("cache")["files"].get<int>() >= 2);
}

TEST_CASE("a state file of the cache that a session writes is left there, and said") {
  const BeamShop shop;
  const std::string held =
      "'" + executable() +
      "' session beam.toml --clock real --seconds 600 --device path:press --quiet -o run & p=$!; " +
      wait_until("ls ../cache/forefeel/*.states-wal >/dev/null 2>&1") + "'" + executable() +
      "' cache --empty --json; code=$?; kill -INT $p; wait $p; exit $code";
  const Workshop::Outcome outcome = shop.shell(held);
  CHECK(outcome.code == 1);
  CHECK(outcome.json()["in_use"].get<int>() > 0);
  CHECK_THAT(outcome.err, Contains("in use by another forefeel"));
}

TEST_CASE("generate asks what its threads will take before it begins") {
  if (sanitized) return skip("a sanitizer needs the whole address space");
  const BeamShop shop;
  // With little memory left, the error names the number of threads that the limit allows.
  const auto outcome = shop.shell("ulimit -v 3000000; " + executable() +
                                  " generate beam.toml -o s.states --threads 4000 2>&1 || echo code $?");
  CHECK_THAT(outcome.out, Contains("--threads", "memory (ulimit -u, -v) allow", "expected at most") &&
                              Catch::EndsWith("code 2\n"));
}
