// The output of forefeel classify for many and for few points.

#include <fmt/format.h>

#include <Eigen/Core>
#include <sstream>

#include "tests/support/executable.hpp"

TEST_CASE("many points are counted by label, few or --list are printed, and the written file is named",
          "[classify]") {
  const Workshop shop;
  std::string states = "x,y,z,fx,fy,fz\n";
  for (int i = 0; i < 125; ++i)
    states += fmt::format("{},{},{},0,0,0\n", 0.006 * (i % 5), 0.006 * (i / 5 % 5), 0.006 * (i / 25));
  shop.write("cube.csv", states);
  const std::string all = "classify cube.csv --spacing 0.006 ";
  const auto lines = [](const std::string& text) { return std::ranges::count(text, '\n'); };
  const std::string grid = shop.forefeel(all + "--grid 0.003 -o cube.svg").out;
  CHECK(lines(grid) < 20);
  CHECK_THAT(grid, Contains("729 points: safe 721, sparse 8, gap 0, blank 0; --list prints each",
                            "picture: cube.svg") &&
                       !Contains("gamma"));
  CHECK(lines(shop.forefeel(all + "--line 0,0,0:0.01,0,0:50 --list").out) > 50);
  const std::string few = shop.forefeel(all + "--line 0,0,0:0.01,0,0:20").out;
  CHECK(lines(few) > 20);
  CHECK_THAT(few, Contains("gamma"));
  CHECK_THAT(shop.forefeel(all + "--grid 0.003 -o labels.csv").out,
             Contains("labels of the points: labels.csv"));
  CHECK_THAT(shop.forefeel(all + "-o regions.csv").out, Contains("regions: regions.csv"));
}

TEST_CASE("states in a plane are labelled in it, wherever it lies; those of a line stay as they are",
          "[classify]") {
  const Workshop shop;
  const auto table = [](int rows, const Eigen::Matrix3d& turn) {
    std::string text = "x,y,z,fx,fy,fz\n";
    for (int i = 0; i < 11; ++i)
      for (int j = 0; j < rows; ++j) {
        const Eigen::Vector3d x = turn * Eigen::Vector3d(0.004 * (i - 5), 0.004 * (j - 5), 0);
        text += fmt::format("{},{},{},0,0,0\n", x[0], x[1], x[2]);
      }
    return text;
  };
  const Eigen::Matrix3d flat = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d tilted;
  tilted << 0.6, 0, 0.8, 0, 1, 0, -0.8, 0, 0.6;
  shop.write("flat.csv", table(11, flat));
  shop.write("tilted.csv", table(11, tilted));
  shop.write("line.csv", table(1, flat));
  for (const char* index : {"delaunay", "octree"}) {
    INFO(index);
    const std::string with = fmt::format(" --spacing 0.004 --json --index {}", index);
    const Workshop::Outcome whole = shop.forefeel("classify flat.csv" + with);
    CHECK_THAT(whole.err, Contains("the states lie in a plane", "1 mm thick"));
    const json volume = whole.json()["volume"];
    CHECK(volume["safe"].get<double>() == Approx(0.04 * 0.04 * 0.001));
    CHECK(volume["blank"].get<double>() == Approx(0).margin(1e-15));
    const json tilted_volume = shop.forefeel("classify tilted.csv" + with).json()["volume"];
    for (const char* label : {"safe", "sparse", "gap", "blank"})
      CHECK(tilted_volume[label].get<double>() == Approx(volume[label].get<double>()).margin(1e-12));
    shop.forefeel(
        fmt::format("classify tilted.csv --spacing 0.004 --index {} "
                    "--line=-0.012,-0.008,0.016:0.012,0.008,-0.016:9 -o t.csv",
                    index));
    const std::string labels = shop.read("t.csv");
    std::size_t safe = 0;
    for (std::size_t at = 0; (at = labels.find(",safe", at)) != std::string::npos; ++at) ++safe;
    CHECK(safe == 9);
    CHECK_THAT(shop.forefeel("classify line.csv" + with).err, !Contains("plane"));
    shop.forefeel(
        fmt::format("classify flat.csv --spacing 0.004 --index {} --line=0,0,0.01:0,0,0.02:2 -o off.csv",
                    index));  // delta: to the states, not to the places beside them
    const std::string off = shop.read("off.csv");
    std::istringstream table_of(off);
    std::string row;
    std::getline(table_of, row);
    for (const double away : {0.01, 0.02}) {
      std::getline(table_of, row);
      for (int comma = 0; comma < 6; ++comma) row.erase(0, row.find(',') + 1);
      CHECK(std::stod(row) == Approx(away));
    }
  }
}

TEST_CASE("scattered points need neither forces nor a spacing", "[classify]") {
  const Workshop shop;
  // Halton's points in the unit cube; then the same in eight small heaps, so that most of their hull is empty.
  const auto halton = [](int i, int base) {
    double value = 0, digit = 1;
    for (; i > 0; i /= base) value += (digit /= base) * (i % base);
    return value;
  };
  std::string cloud, heaps, values = "x,y,z,temperature\n";
  for (int i = 1; i <= 1000; ++i) {
    const Eigen::Vector3d x(halton(i, 2), halton(i, 3), halton(i, 5));
    cloud += fmt::format("{},{},{}\n", x[0], x[1], x[2]);
    values += fmt::format("{},{},{},{}\n", x[0], x[1], x[2], x[0] + 2 * x[1]);
    heaps +=
        fmt::format("{},{},{}\n", 0.1 * x[0] + (i & 1), 0.1 * x[1] + (i >> 1 & 1), 0.1 * x[2] + (i >> 2 & 1));
  }
  shop.write("cloud.csv", cloud);
  shop.write("values.csv", values);
  shop.write("heaps.csv", heaps);
  const json even = json::parse(shop.forefeel("classify cloud.csv --json").out);
  CHECK(even["spacing_estimated"] == true);
  CHECK(even["hull"]["safe_share"] > 0.8);
  CHECK_THAT(shop.forefeel("classify cloud.csv").out, !Contains("would make about"));
  const auto told = shop.forefeel("classify heaps.csv");
  CHECK_THAT(told.out, Contains("of the hull of the states is safe at the estimated spacing; --spacing"));
  const json thin = json::parse(shop.forefeel("classify heaps.csv --json").out);
  CHECK(thin["hull"]["safe_share"] < 0.5);
  const double hull = thin["volume"]["safe"].get<double>() / thin["hull"]["safe_share"].get<double>();
  const json wide = json::parse(shop.forefeel(fmt::format("classify heaps.csv --json --spacing {}",
                                                          thin["hull"]["spacing_90"].get<double>()))
                                    .out);
  CHECK(wide["volume"]["safe"] > 0.75 * hull);  // the hull of eight heaps is the cube of 1.1 m
  CHECK(hull == Approx(1.33).epsilon(0.1));
  CHECK(wide["hull"]["spacing_90"].is_null());

  CHECK_THAT(shop.forefeel("import cloud.csv -o cloud.states").out,
             Contains("1000 places without forces", "(estimated)"));
  CHECK_THAT(shop.forefeel("info cloud.states").out, Contains("no forces"));
  CHECK_THAT(shop.forefeel("evaluate cloud.states --points cloud.csv").err, Contains("holds places alone"));
  CHECK(shop.forefeel("import values.csv -o values.states").code == 0);
  shop.write("query.csv", "0.4,0.5,0.6\n");
  const auto value = shop.forefeel("evaluate values.states --points query.csv --json --no-bars");
  REQUIRE(value.code == 0);
  CHECK_THAT(value.err, !Contains("pull"));
  CHECK(json::parse(value.out)["forces"][0][0].get<double>() == Approx(1.4).epsilon(1e-3));
  CHECK_THAT(shop.forefeel("export cloud.states -o again.csv").out, Contains("1000 states"));
  CHECK_THAT(shop.forefeel("classify again.csv").out, Contains("1000 states"));
}
