// The discretisation error of a mesh beside the errors that commands print.

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "tests/apps/contract.hpp"

using namespace forefeel::test;
using nlohmann::json;

namespace {

const std::string touch = " --clock virtual --seconds 0.5 --device path:press,speed=0.02 ";

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

double of(const json& document) {
  check_keys(document, {"discretisation_error", "discretisation_positions", "discretisation_by"});
  REQUIRE(document["discretisation_error"].is_number());
  CHECK(document["discretisation_positions"] == 3);
  return document["discretisation_error"].get<double>();
}

std::vector<std::filesystem::path> kept(const Workshop& shop) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(shop.path().parent_path()))
    if (entry.path().string().ends_with(".mesh-error.json")) files.push_back(entry.path());
  return files;
}

}  // namespace

TEST_CASE("every command that prints an error says the same of the mesh, measured once") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  shop.write("points.csv", "x,y,z\n0.002,0.001,0\n");
  shop.write("study.toml", "scene = \"beam.toml\"\nseeds = [1]\n[vary]\npolicy = [\"nearest\", \"fifo\"]\n");
  const json session = run_json(shop, "session beam.toml" + touch + "-o run");
  const double error = of(session);
  CHECK(error > 0.02);  // a few linear elements
  REQUIRE(kept(shop).size() == 1);
  const auto before = std::filesystem::last_write_time(kept(shop)[0]);
  CHECK(of(run_json(shop, "session beam.toml --clock real --seconds 0.3 -o real")) == error);
  CHECK(of(run_json(shop, "generate beam.toml --error 0.2 -o beam.states")) == error);
  CHECK(of(run_json(shop, "evaluate beam.states --points points.csv --scene beam.toml")) == error);
  CHECK(run_json(shop, "evaluate beam.states --points points.csv")["discretisation_error"].is_null());
  run_json(shop, "study study.toml -o study --set session.seconds=0.3");
  std::istringstream table(text_of(shop.path() / "study" / "cells.csv"));
  std::string head, row;
  std::getline(table, head);
  std::getline(table, row);
  CHECK_THAT(head, Catch::Contains(
                       "discretisation_error,discretisation_low,discretisation_high,discretisation_positions,"
                       "discretisation_by"));
  CHECK_THAT(row, Catch::Contains("equilibria of quadratic elements on the same mesh"));
  CHECK(kept(shop).size() == 1);
  CHECK(std::filesystem::last_write_time(kept(shop)[0]) == before);
}

TEST_CASE("where the mesh errs by more than a hand feels, that comes first") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const Workshop::Outcome told = shop.forefeel("session beam.toml" + touch + "--cost constant:0.0001 -o run");
  REQUIRE(told.code == 0);
  CHECK_THAT(told.out, Catch::StartsWith("attention: the mesh itself errs by") ||
                           Catch::Contains("\nattention: the mesh itself errs by"));
  const json summary = json::parse(text_of(shop.path() / "run" / "summary.json"));
  REQUIRE(summary["error"]["p95"].get<double>() < summary["discretisation_error"].get<double>());
  CHECK_THAT(summary["attention"][0].get<std::string>(), Catch::StartsWith("the mesh itself errs by"));
  const std::string report = text_of(shop.path() / "run" / "report.html");
  CHECK(report.find("the mesh itself errs by") < report.find("class=\"tiles\""));
}

TEST_CASE("it is the difference that solve finds, and turning it off changes nothing but itself") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const json with = run_json(shop, "session beam.toml" + touch + "-o with");
  const json without =
      run_json(shop, "session beam.toml" + touch + "--set session.discretisation_error=false -o without");
  CHECK(without["discretisation_error"].is_null());
  CHECK_THAT(without["discretisation_by"].get<std::string>(), Catch::StartsWith("not measured"));
  for (const char* file : {"frames.csv", "dispatch.csv", "switches.csv"})
    CHECK(text_of(shop.path() / "with" / file) == text_of(shop.path() / "without" / file));
  // Largest of the same positions, each solved alone and compared with quadratic elements by hand.
  const json kept_value = json::parse(text_of(kept(shop).at(0)));
  CHECK(kept_value["error"] == with["discretisation_error"]);
  const std::string at = " --at=0,0,-0.004";
  const auto force = [&](const std::string& more) {
    return run_json(shop, "solve beam.toml" + at + more)["states"][0];
  };
  const json linear = force(" --discretisation-error"), quadratic = force(" --set body.element=quadratic");
  double difference = 0, norm = 0;
  for (int i = 0; i < 3; ++i) {
    const double f = linear["force"][i], g = quadratic["force"][i];
    difference += (f - g) * (f - g);
    norm += g * g;
  }
  CHECK(linear["discretisation_error"].get<double>() == Approx(std::sqrt(difference / norm)).epsilon(1e-6));
}

TEST_CASE("a kept value that was altered is measured again") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const double error = of(run_json(shop, "session beam.toml" + touch + "-o run"));
  const std::filesystem::path file = kept(shop).at(0);
  const std::string whole = text_of(file);
  json altered = json::parse(whole);
  altered["error"] = 0.5;
  std::ofstream(file) << altered.dump();
  CHECK(of(run_json(shop, "session beam.toml" + touch + "-o run2")) == error);
  CHECK(text_of(file) == whole);
  CHECK(run_json(shop, "cache --empty")["foreign"] == 0);
  CHECK(kept(shop).empty());
}

TEST_CASE(
    "beside a fine body the error has an interval that holds a solved one, and beyond its reach a reason") {
  const Workshop shop;
  shop.write("ball.toml", R"([body]
phantom = "ball"
elements = 500
fine = { elements = 300 }
[material]
law = "neo-hookean"
young = 5000.0
poisson = 0.4
[clamp]
group = "clamp"
[contact]
pad = 1000.0
[state_space]
spacing = 0.01
box = [[-0.02, -0.02, -0.02], [0.02, 0.02, 0.02]]
)");
  const auto solved = [&](const std::string& more) {
    return run_json(shop, "solve ball.toml" + more)["states"];
  };
  const std::string at = " --at=0.006,0,-0.012";
  const json states = solved(at + " --at=0,0,-0.045 --discretisation-error");
  // a mesh that is neither the fine body's nor the one it is compared with
  const json truth =
      solved(at + " --set body.element=quadratic --set body.fine=false --set body.elements=3500")[0];
  double difference = 0, norm = 0;
  for (int i = 0; i < 3; ++i) {
    const double f = states[0]["force"][i], g = truth["force"][i];
    difference += (f - g) * (f - g);
    norm += g * g;
  }
  const double error = std::sqrt(difference / norm);
  CHECK(states[0]["discretisation_interval"][0].get<double>() <= error);
  CHECK(error <= states[0]["discretisation_interval"][1].get<double>());
  CHECK(states[0]["discretisation_error"].get<double>() == Approx(error).epsilon(0.5));
  CHECK(states[0]["warnings"].empty());
  CHECK(states[1]["discretisation_error"].is_null());
  REQUIRE(states[1]["warnings"].size() == 1);
  CHECK_THAT(states[1]["warnings"][0].get<std::string>(), Catch::Contains("from rest only"));
}
