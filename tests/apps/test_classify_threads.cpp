// `forefeel classify` with several threads.

#include <fmt/format.h>

#include "tests/support/executable.hpp"

TEST_CASE("classify writes the same bytes for any number of threads") {
  const Workshop shop;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-0.03, 0.03);
  std::string text = "x,y,z,fx,fy,fz\n";
  for (int i = 0; i < 4000; ++i)
    text += fmt::format("{},{},{},0,0,1\n", uniform(random), uniform(random), uniform(random));
  shop.write("s.csv", text);
  const auto bytes = [&](const std::string& file) {
    std::ifstream in(shop.path() / file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  for (const std::string threads : {"1", "2", "5"}) {
    shop.run("classify s.csv --spacing 0.003 --threads " + threads + " -o r" + threads + ".csv");
    shop.run("classify s.csv --spacing 0.003 --threads " + threads + " --grid 0.004 -o p" + threads + ".csv");
  }
  CHECK(bytes("r1.csv").size() > 100'000);
  CHECK(bytes("r2.csv") == bytes("r1.csv"));
  CHECK(bytes("r5.csv") == bytes("r1.csv"));
  CHECK(bytes("p2.csv") == bytes("p1.csv"));
  CHECK(bytes("p5.csv") == bytes("p1.csv"));
}
