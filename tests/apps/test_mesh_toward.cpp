// forefeel mesh --toward, run as a person would.

#include "tests/support/executable.hpp"

namespace {

const char* const cube_off =
    "OFF\n8 12 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n3 0 2 1\n3 1 2 3\n3 4 5 6\n3 5 7 "
    "6\n3 0 1 4\n3 1 5 4\n3 2 6 3\n3 3 6 7\n3 0 4 2\n3 2 4 6\n3 1 3 5\n3 3 7 5\n";

}  // namespace

TEST_CASE("mesh --toward grades a surface, a phantom and a volume mesh, whose groups stay", "[mesh]") {
  const Workshop shop;
  shop.write("cube.off", cube_off);
  const auto cube = shop.json("mesh cube.off -o cube.msh --elements 1500 --toward 0.5,0.5,1,0.1");
  CHECK(cube["elements"] == Approx(1500).epsilon(0.05));
  CHECK(cube["volume"] == Approx(1).epsilon(1e-6));
  CHECK(cube["toward"]["near"].get<double>() < 0.5 * cube["toward"]["far"].get<double>());
  CHECK(cube["toward"]["distance"] == 0);
  CHECK(cube["warnings"].empty());
  // The place counts in the mesh that is made.
  const auto small =
      shop.json("mesh cube.off -o small.msh --elements 1500 --length 0.1 --toward 0.05,0.05,0.1,0.01");
  CHECK(small["toward"]["near"] == Approx(0.1 * cube["toward"]["near"].get<double>()).epsilon(1e-3));
  CHECK(small["volume"] == Approx(1e-3).epsilon(1e-6));
  const auto beam = shop.json("mesh --phantom beam -o beam.msh --elements 1500 --toward 0.1,0.01,0.01,0.005");
  CHECK(beam["elements"] == Approx(1500).epsilon(0.05));
  CHECK(beam["groups"].contains("clamp"));
  const auto again = shop.json("mesh beam.msh -o finer.msh --elements 4000 --toward 0.1,0.01,0.01,0.005");
  CHECK(again["elements"] == Approx(4000).epsilon(0.05));
  CHECK(again["groups"]["clamp"] > beam["groups"]["clamp"]);
  CHECK(again["groups"].contains("contact"));
  const auto plain = shop.json("mesh cube.off -o even.msh --elements 600");
  CHECK(plain["toward"].empty());
}

TEST_CASE("mesh --toward says how far a place lies from the surface", "[mesh]") {
  const Workshop shop;
  shop.write("cube.off", cube_off);
  const auto made = shop.forefeel("mesh cube.off -o cube.msh --elements 800 --toward 0.5,0.5,3,0.1 --json");
  CHECK(made.json()["toward"]["distance"] == Approx(2));
  CHECK_THAT(made.err,
             Contains("cube.off: --toward: the place is 2 m from the surface", "taken to 0.5, 0.5, 1"));
}

TEST_CASE("mesh --toward refuses what it cannot use", "[mesh]") {
  const Workshop shop;
  shop.write("cube.off", cube_off);
  const std::string cube = "mesh cube.off -o a.msh --elements 500 ";
  check_refused(shop, cube + "--toward 1,2,3", {"--toward", "expected three finite numbers X,Y,Z"});
  check_refused(shop, cube + "--toward here", {"--toward", "'here'", "X,Y,Z,R"});
  check_refused(shop, cube + "--toward=0,0,1,0", {"--toward", "radius R is 0, expected a number above 0"});
  check_refused(shop, cube + "--toward=0,0,1,-0.1", {"--toward", "radius R is -0.1"});
  check_refused(shop, cube + "--toward=0,0,nan,0.1", {"--toward", "three finite numbers"});
  check_refused(shop, "mesh cube.off -o a.msh --toward 0,0,1,0.1", {"--toward", "--elements"});
}
