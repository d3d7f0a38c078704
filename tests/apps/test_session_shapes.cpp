// forefeel session with shapes: files, VTK's view of them, numbers, show; and a session without.

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "tests/apps/contract.hpp"
#include "tests/apps/shown_page.hpp"
#include "tests/apps/vtk_files.hpp"
#include "tests/support/skip.hpp"
#include "tests/support/slow.hpp"

using namespace forefeel::test;
using nlohmann::json;

namespace {

namespace fs = std::filesystem;

const std::string press = " --clock virtual --seconds 1 --device path:circle,speed=0.03 --quiet";

json series(const Workshop& shop, const std::string& run) {
  return forefeel::test::read_by_vtk(shop, run, "read_shapes.py");
}

}  // namespace

TEST_CASE("a session with shapes: VTK opens the series, and the numbers are in the summary",
          "[shapes]" SLOW("compares with VTK, which only run.sh all installs")) {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const json summary = run_json(shop, "session beam.toml --shape-rate 30 -o run" + press);
  check_keys(summary["shape"], {"rate", "nodes", "shapes", "missed", "largest", "error.p50", "error.p95",
                                "error.max", "error.by_label.safe.p95", "error.node_p95.p95"});
  CHECK(summary["shape"]["rate"] == 30);
  CHECK(summary["shape"]["shapes"] == 30);
  CHECK(summary["shape"]["missed"] == 0);
  CHECK(summary["shape"]["error"]["samples"] == 20);
  CHECK(summary["shape"]["cost_us"]["p50"].is_null());
  CHECK(summary == json::parse(bytes_of(shop.path() / "run/summary.json")));
  const std::string table = bytes_of(shop.path() / "run/shape.csv");
  CHECK(std::count(table.begin(), table.end(), '\n') == 31);
  const json shapes = series(shop, "run");
  if (shapes.is_null()) return;
  REQUIRE(shapes.size() == 30);
  double largest = 0;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    CHECK(shapes[k]["t"].get<double>() == Approx(double(k) / 30).margin(0.0011));
    CHECK(shapes[k]["time_value"] == shapes[k]["t"]);
    CHECK(shapes[k]["types"] == json({5}));
    CHECK(shapes[k]["rest"] == shapes[0]["rest"]);  // points less displacements
    CHECK(shapes[k]["node"].size() == summary["shape"]["nodes"]);
    largest = std::max(largest, shapes[k]["largest"].get<double>());
  }
  CHECK(largest == Approx(summary["shape"]["largest"].get<double>()).epsilon(1e-5));
  // Another mesh writer knows the same places at rest.
  REQUIRE(shop.forefeel("show beam.toml -o beam.vtu --quiet").code == 0);
}

TEST_CASE("the whole body: tetrahedra of all nodes, from the scene's own keys",
          "[shapes]" SLOW("compares with VTK, which only run.sh all installs")) {
  const Workshop shop;
  shop.write("beam.toml",
             beam_scene("[session]\nshape_rate = 25\nshape_surface = false\nshape_checks = 2\n"));
  const json summary = run_json(shop, "session beam.toml -o run" + press);
  CHECK(summary["shape"]["surface"] == false);
  CHECK(summary["shape"]["error"]["samples"] == 2);
  const json shapes = series(shop, "run");
  if (shapes.is_null()) return;
  REQUIRE(shapes.size() == 25);
  CHECK(shapes[3]["types"] == json({10}));
}

TEST_CASE("a session without shapes is the same to the byte, and removes those of an earlier run",
          "[shapes]") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  REQUIRE(shop.forefeel("session beam.toml -o without" + press).code == 0);
  REQUIRE(shop.forefeel("session beam.toml --shape-rate 30 -o with" + press).code == 0);
  for (const char* file : {"frames.csv", "dispatch.csv", "switches.csv", "states.csv"})
    CHECK(bytes_of(shop.path() / "without" / file) == bytes_of(shop.path() / "with" / file));
  CHECK_FALSE(fs::exists(shop.path() / "without/shape.pvd"));
  CHECK_FALSE(fs::exists(shop.path() / "without/shape.csv"));
  CHECK(bytes_of(shop.path() / "without/.forefeel").find("shape") == std::string::npos);
  CHECK_FALSE(json::parse(bytes_of(shop.path() / "without/summary.json")).contains("shape"));
  CHECK(bytes_of(shop.path() / "without/report.html").find("shape_rate") == std::string::npos);
  CHECK(fs::exists(shop.path() / "with/shape.pvd"));
  REQUIRE(shop.forefeel("session beam.toml -o with" + press).code == 0);
  for (const char* file : {"shape.pvd", "shape.csv", "shape"})
    CHECK_FALSE(fs::exists(shop.path() / "with" / file));
}

TEST_CASE("states that hold no displacements are refused in one line; with them they are shaped",
          "[shapes]") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const std::string session = "session beam.toml --shape-rate 30 --states ";
  REQUIRE(shop.forefeel("generate beam.toml -o bare.states --quiet").code == 0);
  check_refused(shop, session + "bare.states -o run" + press,
                {"bare.states", "hold no displacements", "session.shape_rate"});
  shop.write("measured.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0,0,0.002,0,0,-1\n");
  check_refused(shop, session + "measured.csv --foreign -o run" + press, {"--foreign", "shape"});
  check_refused(shop, "session beam.toml --shape-rate 500 -o run" + press,
                {"--shape-rate", "500", "0 to 200"});
  check_refused(shop, "session beam.toml --set session.shape_rate=-1 -o run" + press,
                {"session.shape_rate", "0 to 200"});
  REQUIRE(shop.forefeel("generate beam.toml --set session.shape_rate=30 -o full.states --quiet").code == 0);
  const json summary = run_json(shop, session + "full.states -o run" + press);
  CHECK(summary["shape"]["error"]["by_label"]["safe"]["samples"] > 10);
  CHECK(summary["shape"]["error"]["by_label"]["safe"]["p95"] < 0.01);
}

TEST_CASE("somebody's own file named shape.csv is not replaced", "[shapes]") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  REQUIRE(shop.forefeel("session beam.toml -o run" + press).code == 0);
  shop.write("run/shape.csv", "mine\n");
  const auto refused = shop.forefeel("session beam.toml --shape-rate 30 -o run" + press);
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Catch::Contains("shape.csv"));
  REQUIRE(shop.forefeel("session beam.toml -o run" + press).code == 0);
  CHECK(bytes_of(shop.path() / "run/shape.csv") == "mine\n");
}

TEST_CASE("show draws the recorded shapes over time",
          "[shapes]" SLOW("compares with VTK, which only run.sh all installs")) {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  REQUIRE(shop.forefeel("session beam.toml --shape-rate 30 -o run" + press).code == 0);
  const auto made = shop.forefeel("show run -o run.html --json");
  if (made.code == 2 && made.err.find("three.js") != std::string::npos)
    return skip("three.js was not found at build time and is not installed");
  INFO(made.err);
  REQUIRE(made.code == 0);
  const ShownPage page(shop.path() / "run.html");
  const json& shown = page.data["run"]["shapes"];
  const auto times = floats(shown["t"]);
  const auto moved = numbers<std::int16_t>(shown["moved"], "i16");
  REQUIRE(times.size() == 30);
  REQUIRE(moved.size() == 30 * floats(page.data["body"]["nodes"]).size());
  const json shapes = series(shop, "run");
  if (shapes.is_null()) return;
  const double scale = shown["scale"];
  const auto nodes = numbers<std::uint32_t>(page.data["body"]["node"], "u32");
  for (std::size_t k = 0; k < 30; k += 7)
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      REQUIRE(shapes[k]["node"][i] == nodes[i]);
      for (std::size_t c = 0; c < 3; ++c)
        CHECK(scale * moved[3 * (k * nodes.size() + i) + c] ==
              Approx(shapes[k]["moved"][i][c].get<double>()).margin(scale));
    }
  fs::remove(shop.path() / "run/shape/shape_000000.vtu");
  check_refused(shop, "show run -o again.html", {"shape_000000.vtu"});
}
