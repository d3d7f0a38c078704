// forefeel session of a scene with contact.anywhere: its files, what it refuses, recorded motions.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "geometry/common/csv_table.hpp"
#include "tests/support/executable.hpp"
#include "tests/support/file_text.hpp"

using namespace forefeel;
using test::check_refused;
using test::Workshop;

namespace {

// The beam of 10 x 2 x 2 cm, clamped at x = 0. law: linear, or another.
std::string beam(const std::string& law, const std::string& contact = "") {
  return "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"" + law +
         "\"\nyoung = 5000.0\npoisson = 0.3\n[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\n" +
         contact + "[state_space]\ndepth = 0.004\n";
}

}  // namespace

TEST_CASE("a session touches anywhere: columns, labels, errors, states that the next one knows") {
  const Workshop shop;
  shop.write("any.toml", beam("neo-hookean", "friction = 0.3\n"));
  const Workshop::Outcome run = shop.forefeel(
      "session any.toml --device path:tour,depth=0.003 --clock virtual --seconds 3 --workers 2 -o run "
      "--json");
  INFO(run.err);
  REQUIRE(run.code == 0);
  const nlohmann::json said = run.json();
  CHECK(said["frames"] == 3000);
  CHECK(said["touch"]["slid"].get<double>() > 0.01);
  CHECK(said["touch"]["cone"].get<double>() < 1e-3);
  CHECK(said["error"]["samples"]["samples"].get<int>() > 10);
  CHECK(said["error"]["samples"]["p95"].get<double>() < 0.05);
  CHECK(said["switching"]["over_bound"] == 0);
  const CsvTable frames =
      read_csv(shop.path() / "run/frames.csv", std::array<std::string_view, 2>{"x", "fx"});
  CHECK(frames.rows() == 3000);
  const std::string text = test::file_text(shop, "run/frames.csv");
  for (const char* word : {"touch", ",slip,", ",stick,", ",none,", "trusted", "sx,sy,sz"})
    CHECK(text.find(word) != std::string::npos);
  CHECK(test::file_text(shop, "run/report.html").find("Where the hand was") != std::string::npos);
  const Workshop::Outcome next = shop.forefeel(
      "session any.toml --device path:tour,depth=0.003 --clock virtual --seconds 1 --states "
      "run/session.states -o "
      "again --json");
  INFO(next.err);
  REQUIRE(next.code == 0);
}

TEST_CASE("a linear body is exact everywhere, without a state") {
  const Workshop shop;
  shop.write("any.toml", beam("linear"));
  const Workshop::Outcome run = shop.forefeel(
      "session any.toml --device path:palpation,depth=0.003 --clock virtual --seconds 4 --switch none -o run "
      "--json");
  INFO(run.err);
  REQUIRE(run.code == 0);
  const nlohmann::json said = run.json();
  CHECK(said["touch"]["count"].get<int>() > 1);
  CHECK(said["states"]["solved"] == 0);
  // Facets are polynomials: exact at their places alone.
  CHECK(said["error"]["samples"]["p95"].get<double>() < 0.01);
}

TEST_CASE("a recorded motion is registered by its first sample and the normal") {
  const Workshop shop;
  shop.write("any.toml", beam("neo-hookean"));
  std::string trace = "t,x,y,z\n";
  for (int i = 0; i <= 100; ++i)
    trace += std::to_string(0.01 * i) + ",5,7," + std::to_string(9 - 0.003 * std::sin(0.0314159 * i)) + "\n";
  shop.write("motion.csv", trace);
  const Workshop::Outcome run = shop.forefeel(
      "session any.toml --device trace:motion.csv,register=0.06/0.01/0.03 --clock virtual -o run --json");
  INFO(run.err);
  REQUIRE(run.code == 0);
  CHECK(run.json()["touch"]["count"] == 1);
  const CsvTable frames =
      read_csv(shop.path() / "run/frames.csv", std::array<std::string_view, 3>{"x", "y", "z"});
  double deepest = 1;
  for (std::size_t i = 0; i < frames.rows(); ++i) {
    CHECK(std::abs(frames.at(i, 0) - 0.06) < 1e-9);
    deepest = std::min(deepest, frames.at(i, 2));
  }
  CHECK(deepest == Approx(0.02 - 0.003).margin(1e-5));
}

TEST_CASE("what is for one place is refused, and what is for a surface elsewhere") {
  const Workshop shop;
  shop.write("any.toml", beam("neo-hookean"));
  shop.write("plain.toml", test::beam_scene());
  const std::string start = "session any.toml --clock virtual --seconds 1 -o run ";
  check_refused(shop, start + "--device path:circle", {"path:circle", "palpation"});
  check_refused(shop, start + "--device path:line,amplitude=0.01", {"amplitude", "depth"});
  check_refused(shop, start + "--device path:line,where=nowhere", {"where", "nowhere"});
  check_refused(shop, start + "--device path:line,where=5/5/5/0.01", {"where"});
  check_refused(shop, start + "--policy clairvoyant", {"session.policy", "contact.anywhere"});
  check_refused(shop, start + "--switch paper", {"session.switch", "contact.anywhere"});
  check_refused(shop, start + "--shape-rate 10", {"--shape-rate", "contact.anywhere"});
  const std::string plain = "session plain.toml --clock virtual --seconds 1 -o run ";
  check_refused(shop, plain + "--device path:line,depth=0.003", {"depth", "contact.anywhere"});
  CHECK_FALSE(std::filesystem::exists(shop.path() / "run/frames.csv"));
}
