// forefeel session with shapes: files, VTK's view of them, numbers, show; and a session without.

#include "tests/apps/contract.hpp"
#include "tests/apps/shown_page.hpp"
#include "tests/apps/vtk_files.hpp"

namespace {

const std::string press = " --clock virtual --seconds 1 --device path:circle,speed=0.03 --quiet";

json series(const Workshop& shop, const std::string& run) {
  return forefeel::test::read_by_vtk(shop, run, "read_shapes.py");
}

}  // namespace

TEST_CASE("a session with shapes: VTK opens the series, and the numbers are in the summary",
          "[shapes]" SLOW("compares with VTK, which only run.sh all installs")) {
  const BeamShop shop;
  const json summary = shop.json("session beam.toml --shape-rate 30 -o run" + press);
  check_keys(summary["shape"], {"rate", "nodes", "shapes", "missed", "largest", "error.p50", "error.p95",
                                "error.max", "error.by_label.safe.p95", "error.node_p95.p95"});
  CHECK(summary["shape"]["rate"] == 30);
  CHECK(summary["shape"]["shapes"] == 30);
  CHECK(summary["shape"]["missed"] == 0);
  CHECK(summary["shape"]["error"]["samples"] == 20);
  CHECK(summary["shape"]["cost_us"]["p50"].is_null());
  CHECK(summary == json::parse(text_of(shop.path() / "run/summary.json")));
  const std::string table = text_of(shop.path() / "run/shape.csv");
  CHECK(std::count(table.begin(), table.end(), '\n') == 31);
  const json shapes = series(shop, "run");
  if (shapes.is_null()) return;
  REQUIRE(shapes.size() == 30);
  double largest = 0;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    CHECK(shapes[k]["t"] == Approx(double(k) / 30).margin(0.0011));
    CHECK(shapes[k]["time_value"] == shapes[k]["t"]);
    CHECK(shapes[k]["types"] == json({5}));
    CHECK(shapes[k]["rest"] == shapes[0]["rest"]);  // points less displacements
    CHECK(shapes[k]["node"].size() == summary["shape"]["nodes"]);
    largest = std::max(largest, shapes[k]["largest"].get<double>());
  }
  CHECK(largest == Approx(summary["shape"]["largest"].get<double>()).epsilon(1e-5));
  // Another mesh writer knows the same places at rest.
  shop.run("show beam.toml -o beam.vtu --quiet");
}

TEST_CASE("the whole body: tetrahedra of all nodes, from the scene's own keys",
          "[shapes]" SLOW("compares with VTK, which only run.sh all installs")) {
  const BeamShop shop("[session]\nshape_rate = 25\nshape_surface = false\nshape_checks = 2\n");
  const json summary = shop.json("session beam.toml -o run" + press);
  CHECK(summary["shape"]["surface"] == false);
  CHECK(summary["shape"]["error"]["samples"] == 2);
  const json shapes = series(shop, "run");
  if (shapes.is_null()) return;
  REQUIRE(shapes.size() == 25);
  CHECK(shapes[3]["types"] == json({10}));
}

TEST_CASE("a session without shapes is the same to the byte, and removes those of an earlier run",
          "[shapes]") {
  const BeamShop shop;
  shop.run("session beam.toml -o without" + press);
  shop.run("session beam.toml --shape-rate 30 -o with" + press);
  for (const char* file : {"frames.csv", "dispatch.csv", "switches.csv", "states.csv"})
    CHECK(text_of(shop.path() / "without" / file) == text_of(shop.path() / "with" / file));
  CHECK_FALSE(fs::exists(shop.path() / "without/shape.pvd"));
  CHECK_FALSE(fs::exists(shop.path() / "without/shape.csv"));
  CHECK_THAT(text_of(shop.path() / "without/.forefeel"), !Contains("shape"));
  CHECK_FALSE(json::parse(text_of(shop.path() / "without/summary.json")).contains("shape"));
  CHECK_THAT(text_of(shop.path() / "without/report.html"), !Contains("shape_rate"));
  CHECK(fs::exists(shop.path() / "with/shape.pvd"));
  shop.run("session beam.toml -o with" + press);
  for (const char* file : {"shape.pvd", "shape.csv", "shape"})
    CHECK_FALSE(fs::exists(shop.path() / "with" / file));
}

TEST_CASE("states that hold no displacements are refused in one line; with them they are shaped",
          "[shapes]") {
  const BeamShop shop;
  const std::string session = "session beam.toml --shape-rate 30 --states ";
  shop.run("generate beam.toml -o bare.states --quiet");
  check_refused(shop, session + "bare.states -o run" + press,
                {"bare.states", "hold no displacements", "session.shape_rate"});
  shop.write("measured.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0,0,0.002,0,0,-1\n");
  check_refused(shop, session + "measured.csv --foreign -o run" + press, {"--foreign", "shape"});
  check_refused(shop, "session beam.toml --shape-rate 500 -o run" + press,
                {"--shape-rate", "500", "0 to 200"});
  check_refused(shop, "session beam.toml --set session.shape_rate=-1 -o run" + press,
                {"session.shape_rate", "0 to 200"});
  shop.run("generate beam.toml --set session.shape_rate=30 -o full.states --quiet");
  const json summary = shop.json(session + "full.states -o run" + press);
  CHECK(summary["shape"]["error"]["by_label"]["safe"]["samples"] > 10);
  CHECK(summary["shape"]["error"]["by_label"]["safe"]["p95"] < 0.01);
}

TEST_CASE("somebody's own file named shape.csv is not replaced", "[shapes]") {
  const BeamShop shop;
  shop.run("session beam.toml -o run" + press);
  shop.write("run/shape.csv", "mine\n");
  check_refused(shop, "session beam.toml --shape-rate 30 -o run" + press, {"shape.csv"});
  shop.run("session beam.toml -o run" + press);
  CHECK(text_of(shop.path() / "run/shape.csv") == "mine\n");
}

TEST_CASE("show draws the recorded shapes over time",
          "[shapes]" SLOW("compares with VTK, which only run.sh all installs")) {
  const BeamShop shop;
  shop.run("session beam.toml --shape-rate 30 -o run" + press);
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
