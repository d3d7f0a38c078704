// The page of forefeel show under a real mouse, where chromium is installed (`apps/setup.sh all`).

#include "tests/apps/shown_page.hpp"
#include "tests/support/executable.hpp"

namespace {

double distance(const json& a, const json& b) {
  double square = 0;
  for (std::size_t i = 0; i < 3; ++i) square += std::pow(a[i].get<double>() - b[i].get<double>(), 2);
  return std::sqrt(square);
}

// Largest component of any node's displacement at time t, linear between the page's shapes [mm].
double moved_at(const ShownPage& page, double t) {
  const json& shapes = page.data["run"]["shapes"];
  const auto times = floats(shapes["t"]);
  const auto moved = numbers<std::int16_t>(shapes["moved"], "i16");
  const std::size_t n = moved.size() / times.size();
  std::size_t i = 0;
  while (i + 1 < times.size() && times[i + 1] <= t) ++i;
  const std::size_t next = std::min(i + 1, times.size() - 1);
  const double share = next > i ? (t - times[i]) / (times[next] - times[i]) : 0;
  double most = 0;
  for (std::size_t k = 0; k < n; ++k)
    most = std::max(most, std::abs((1 - share) * moved[i * n + k] + share * moved[next * n + k]));
  return 1e3 * shapes["scale"].get<double>() * most;
}

}  // namespace

TEST_CASE("show in a browser: drag turns, the wheel zooms, the time moves the body, the pointer reads off",
          "[show]" SLOW("starts Chromium, which only run.sh all installs")) {
  const BeamShop shop;
  shop.run(
      "session beam.toml --clock virtual --seconds 1 --device path:circle,speed=0.03 --shape-rate 30 "
      "-o run --quiet");
  const auto made = shop.forefeel("show run -o run.html --quiet");
  if (made.code == 2 && made.err.find("three.js") != std::string::npos)
    return skip("three.js was not found at build time and is not installed");
  REQUIRE(made.code == 0);
  const auto used = shop.shell("timeout 300 /usr/bin/python3 '" +
                               (source_folder() / "tests/apps/use_page.py").string() + "' run.html");
  if (used.code == 77 || used.code == 127) return skip("chromium with WebGL is not installed");
  INFO(used.err);
  REQUIRE(used.code == 0);
  const json found = used.json();
  const json& target = found["target"];
  CHECK(distance(found["turned"], found["before"]["camera"]) > 0.1 * distance(target, found["turned"]));
  CHECK(distance(target, found["turned"]) == Approx(distance(target, found["before"]["camera"])));
  CHECK(distance(target, found["zoomed"]) > 1.02 * distance(target, found["turned"]));
  const double now = found["later"]["now"];
  CHECK(now == Approx(0.5).margin(0.05));
  const ShownPage page(shop.path() / "run.html");
  CHECK(found["before"]["now"] > 0.95);  // opens at the end, where most is known
  CHECK(found["before"]["moved"] == Approx(moved_at(page, found["before"]["now"])).margin(1e-3));
  CHECK(found["later"]["moved"] == Approx(moved_at(page, now)).margin(1e-3));
  CHECK(found["later"]["moved"] > 1);
  CHECK_THAT(found["later"]["text"].get<std::string>(),
             Catch::StartsWith("t = 0.") && Contains("states known"));
  REQUIRE(found["tip"].is_string());
  CHECK_THAT(found["tip"].get<std::string>(), Catch::StartsWith("node ") && Contains("in the mesh"));
  CHECK(found["edges"][0] != found["edges"][1]);
}
