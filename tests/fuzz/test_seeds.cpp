// The fuzz targets without libFuzzer: their seeds, and some mutations that are the same in each run.

#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>

#include "tests/fuzz/targets.hpp"

namespace forefeel::fuzz {
namespace {

constexpr int mutations_of_a_seed = 60;

std::vector<Target> targets() {
  std::vector<Target> all = geometry_targets();
  for (const auto& more : {table_targets(), text_targets()}) all.insert(all.end(), more.begin(), more.end());
  return all;
}

std::size_t below(std::mt19937& random, std::size_t end) {
  return end == 0 ? 0 : random() % end;
}

std::string mutated(std::string input, std::mt19937& random) {
  static const std::vector<std::string> pieces{
      "0", "-1",   "1e300", "nan",        "inf",  "99999999999999999999", "\n", ",", "=", "\"", "[", "]",
      "#", "\xff", "..",    "4294967296", "1e-9", std::string(300, 'x')};
  for (std::size_t changes = 1 + below(random, 4); changes > 0; --changes) {
    const std::size_t at = below(random, input.size() + 1);
    switch (random() % 5) {
      case 0:
        input.resize(at);
        break;
      case 1:
        if (at < input.size()) input[at] = static_cast<char>(random());
        break;
      case 2:
        input.insert(at, pieces[below(random, pieces.size())]);
        break;
      case 3:
        input.erase(at, 1 + below(random, 8));
        break;
      default:
        input.insert(at, input.substr(below(random, input.size() + 1), below(random, 40)));
    }
  }
  return input;
}

std::string complaint(const Target& target, const std::string& input) {
  try {
    run_target(target, input);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("every target takes its seeds, and no change of them crashes it or breaks its promise") {
  for (const Target& target : targets()) {
    INFO(target.name);
    std::mt19937 random(11);
    for (const std::string& seed : target.seeds()) {
      CHECK_NOTHROW(target.run(seed));
      for (int i = 0; i < mutations_of_a_seed; ++i) {
        const std::string input = mutated(seed, random);
        const std::string what = complaint(target, input);
        if (!what.empty()) FAIL_CHECK(what << " for\n" << input.substr(0, 2000));
      }
    }
  }
}

TEST_CASE("the seeds as files, for libFuzzer", "[.seeds]") {
  const char* folder = std::getenv("FOREFEEL_SEEDS");
  REQUIRE(folder);
  for (const Target& target : targets()) {
    const std::filesystem::path below_it = std::filesystem::path(folder) / target.name;
    std::filesystem::create_directories(below_it);
    int number = 0;
    for (const std::string& seed : target.seeds())
      std::ofstream(below_it / ("seed-" + std::to_string(number++)), std::ios::binary) << seed;
  }
}

}  // namespace forefeel::fuzz
