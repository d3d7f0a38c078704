// The output of forefeel classify for many and for few points.

#include <fmt/format.h>

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
