// Error bars without a session, by the commands: against tight solves, their columns, and a tolerance in newtons.

#include <fmt/format.h>

#include "tests/support/executable.hpp"

namespace {

double distance(const json& a, const json& b) {
  return std::hypot(a[0].get<double>() - b[0].get<double>(), a[1].get<double>() - b[1].get<double>(),
                    a[2].get<double>() - b[2].get<double>());
}

// Positions drawn in the box of the beam scene's states.
std::string drawn_points(const json& box, int count) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> share(0, 1);
  std::string text = "x,y,z\n";
  for (int i = 0; i < count; ++i) {
    std::string row;
    for (int axis = 0; axis < 3; ++axis) {
      const double low = box[0][axis].get<double>(), high = box[1][axis].get<double>();
      row += fmt::format("{}{}", axis > 0 ? "," : "", low + (high - low) * share(random));
    }
    text += row + "\n";
  }
  return text;
}

}  // namespace

TEST_CASE("bars of evaluate hold tight solves at other places; what is known within a tolerance is") {
  const BeamShop shop;
  shop.run("generate beam.toml -o l.states --quiet");
  const auto whole = shop.json("classify l.states --bars --tolerance 0.02");
  shop.write("q.csv", drawn_points(whole["box"], 120));
  const auto truth = shop.json("solve beam.toml --points q.csv")["states"];
  const auto found = shop.json("evaluate l.states --points q.csv");
  REQUIRE(found["bar95"].size() == 120);
  std::array<int, 3> inside{};
  for (std::size_t i = 0; i < 120; ++i) {
    const double error = distance(found["forces"][i], truth[i]["force"]);
    inside[0] += error <= found["bar90"][i].get<double>();
    inside[1] += error <= found["bar95"][i].get<double>();
    CHECK(found["bar95"][i].get<double>() >= found["bar90"][i].get<double>());
  }
  INFO(inside[0] << " and " << inside[1] << " of 120 inside");
  CHECK(inside[0] >= 0.83 * 120);  // 90 and 95 % less 2.5 deviations of 120
  CHECK(inside[1] >= 0.90 * 120);
  CHECK(found["error_bar"]["samples"].get<int>() > 20);

  const auto at = shop.json("classify l.states --bars --tolerance 0.02 --points q.csv");
  REQUIRE(at["known"].size() == 120);
  int known = 0, right = 0;
  for (std::size_t i = 0; i < 120; ++i) {
    if (!at["known"][i].get<bool>()) continue;
    const double f = std::sqrt(std::pow(truth[i]["force"][0].get<double>(), 2) +
                               std::pow(truth[i]["force"][1].get<double>(), 2) +
                               std::pow(truth[i]["force"][2].get<double>(), 2));
    ++known;
    right += distance(found["forces"][i], truth[i]["force"]) <= 0.02 * std::max(f, 0.05);
  }
  INFO(right << " of " << known);
  CHECK(right >= 0.93 * known);
  CHECK(at["tolerance"]["unit"] == "1");
}

TEST_CASE("bars are columns behind the others; without them the files are as before") {
  const BeamShop shop;
  shop.run("generate beam.toml -o l.states --quiet");
  shop.write("q.csv", "x,y,z\n0.001,0.001,0\n0.002,0,0.001\n");
  shop.run("evaluate l.states --points q.csv -o with.csv");
  shop.run("evaluate l.states --points q.csv -o without.csv --no-bars");
  const std::string with = shop.read("with.csv"), without = shop.read("without.csv");
  CHECK(with.starts_with("x,y,z,fx,fy,fz,label,bar90,bar95,bar99\n"));
  CHECK(without.starts_with("x,y,z,fx,fy,fz,label\n"));
  const auto second = [](const std::string& text) {
    return text.substr(text.find('\n') + 1, text.find('\n', text.find('\n') + 1) - text.find('\n') - 1);
  };
  CHECK(second(with).starts_with(second(without) + ","));
  CHECK(!shop.json("evaluate l.states --points q.csv --no-bars").contains("bar95"));
  shop.run("classify l.states --bars --points q.csv -o c.csv");
  CHECK(shop.read("c.csv").starts_with("x,y,z,label,spread,alpha,delta,gamma_deg,bar90,bar95,bar99,known\n"));
  const auto written = shop.run("classify l.states --bars -o c.vtu");
  CHECK_THAT(written.out, Contains("known within 7 %"));
  CHECK_THAT(shop.read("c_left_out.vtu"), Contains("Name=\"bar95\""));
}

TEST_CASE("classify suggests a spacing to states that have none, and says why") {
  const Workshop shop;
  std::string states = "x,y,z,fx,fy,fz\n";
  std::mt19937 random(1);
  std::uniform_real_distribution<double> side(-0.02, 0.02);
  for (int i = 0; i < 150; ++i) {
    const double x = side(random), y = side(random), z = side(random);
    states += fmt::format("{},{},{},{},{},{}\n", x, y, z, 100 * std::sin(90 * x), 100 * y, 100 * z);
  }
  shop.write("own.csv", states);
  CHECK_THAT(shop.forefeel("classify own.csv").out, Contains("suggested: --spacing 0.0", "lie within 7 %"));
  CHECK_THAT(shop.forefeel("classify own.csv --spacing 0.006").out, !Contains("suggested"));
  CHECK(shop.json("classify own.csv")["spacing_suggested"]["safe"].get<int>() >= 20);
}

TEST_CASE("a tolerance in newtons: what is refused, and what a session says of it") {
  const BeamShop shop;
  const std::string run =
      "session beam.toml --clock virtual --seconds 2 --device path:circle,speed=0.04 --json -o run --set "
      "state_space.";
  const auto document = shop.forefeel(run + "'tolerance=\"0.05 N\"'").json();
  CHECK(document["tolerance"]["unit"] == "N");
  CHECK(document["tolerance"]["value"] == 0.05);
  const auto relative = shop.forefeel(run + "tolerance=0.05").json();
  CHECK(relative["tolerance"]["unit"] == "1");
  CHECK(relative["tolerance"]["samples"] == relative["error"]["samples"]);
  CHECK(!shop.forefeel(run + "displacements=false").json().contains("tolerance"));
  for (const char* wrong : {"tolerance=\"0.05\"", "tolerance=\"-1 N\"", "tolerance=\"5 kg\""}) {
    check_refused(shop, run + fmt::format("'{}'", wrong), {"state_space.tolerance", "0.07 N"});
  }
  check_refused(
      shop, "solve beam.toml --at=0,0,0 --set state_space.spacing=auto --set 'state_space.tolerance=\"1 N\"'",
      {"auto"});
  CHECK(shop.forefeel("classify setup:gap --bars").code == 2);
  CHECK(shop.forefeel("classify setup:gap --tolerance 0.1").code == 2);
}
