// The discretisation error of a mesh beside the errors that commands print.

#include "tests/apps/contract.hpp"

namespace {

const std::string touch = " --clock virtual --seconds 0.5 --device path:press,speed=0.02 ";

double of(const json& document) {
  check_keys(document, {"discretisation_error", "discretisation_positions", "discretisation_by"});
  REQUIRE(document["discretisation_error"].is_number());
  CHECK(document["discretisation_positions"] == 3);
  return document["discretisation_error"].get<double>();
}

std::vector<fs::path> kept(const Workshop& shop) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(shop.path().parent_path()))
    if (entry.path().string().ends_with(".mesh-error.json")) files.push_back(entry.path());
  return files;
}

}  // namespace

TEST_CASE("every command that prints an error says the same of the mesh, measured once") {
  const BeamShop shop;
  shop.write("points.csv", "x,y,z\n0.002,0.001,0\n");
  shop.write("study.toml", "scene = \"beam.toml\"\nseeds = [1]\n[vary]\npolicy = [\"nearest\", \"fifo\"]\n");
  const json session = shop.json("session beam.toml" + touch + "-o run");
  const double error = of(session);
  CHECK(error > 0.02);  // a few linear elements
  REQUIRE(kept(shop).size() == 1);
  const auto before = fs::last_write_time(kept(shop)[0]);
  CHECK(of(shop.json("session beam.toml --clock real --seconds 0.3 -o real")) == error);
  CHECK(of(shop.json("generate beam.toml --error 0.2 -o beam.states")) == error);
  CHECK(of(shop.json("evaluate beam.states --points points.csv --scene beam.toml")) == error);
  CHECK(shop.json("evaluate beam.states --points points.csv")["discretisation_error"].is_null());
  shop.json("study study.toml -o study --set session.seconds=0.3");
  std::istringstream table(shop.read("study/cells.csv"));
  std::string head, row;
  std::getline(table, head);
  std::getline(table, row);
  CHECK_THAT(head,
             Contains("discretisation_error,discretisation_low,discretisation_high,discretisation_positions,"
                      "discretisation_by"));
  CHECK_THAT(row, Contains("equilibria of quadratic elements on the same mesh"));
  CHECK(kept(shop).size() == 1);
  CHECK(fs::last_write_time(kept(shop)[0]) == before);
}

TEST_CASE("where the mesh errs by more than a hand feels, that comes first") {
  const BeamShop shop;
  const auto told = shop.run("session beam.toml" + touch + "--cost constant:0.0001 -o run");
  CHECK_THAT(told.out, Catch::StartsWith("attention: the mesh itself errs by") ||
                           Contains("\nattention: the mesh itself errs by"));
  const json summary = json::parse(shop.read("run/summary.json"));
  REQUIRE(summary["error"]["p95"].get<double>() < summary["discretisation_error"].get<double>());
  CHECK_THAT(summary["attention"][0].get<std::string>(), Catch::StartsWith("the mesh itself errs by"));
  const std::string report = shop.read("run/report.html");
  CHECK(report.find("the mesh itself errs by") < report.find("class=\"tiles\""));
}

TEST_CASE("it is the difference that solve finds, and turning it off changes nothing but itself") {
  const BeamShop shop;
  const json with = shop.json("session beam.toml" + touch + "-o with");
  const json without =
      shop.json("session beam.toml" + touch + "--set session.discretisation_error=false -o without");
  CHECK(without["discretisation_error"].is_null());
  CHECK_THAT(without["discretisation_by"].get<std::string>(), Catch::StartsWith("not measured"));
  for (const std::string file : {"/frames.csv", "/dispatch.csv", "/switches.csv"})
    CHECK(shop.same("with" + file, "without" + file));
  // Largest of the same positions, each solved alone and compared with quadratic elements by hand.
  const json kept_value = json::parse(text_of(kept(shop).at(0)));
  CHECK(kept_value["error"] == with["discretisation_error"]);
  const std::string at = " --at=0,0,-0.004";
  const auto force = [&](const std::string& more) {
    return shop.json("solve beam.toml" + at + more)["states"][0];
  };
  const json linear = force(" --discretisation-error"), quadratic = force(" --set body.element=quadratic");
  double difference = 0, norm = 0;
  for (int i = 0; i < 3; ++i) {
    const double f = linear["force"][i], g = quadratic["force"][i];
    difference += (f - g) * (f - g);
    norm += g * g;
  }
  CHECK(linear["discretisation_error"] == Approx(std::sqrt(difference / norm)).epsilon(1e-6));
}

TEST_CASE("a kept value that was altered is measured again") {
  const BeamShop shop;
  const double error = of(shop.json("session beam.toml" + touch + "-o run"));
  const fs::path file = kept(shop).at(0);
  const std::string whole = text_of(file);
  json altered = json::parse(whole);
  altered["error"] = 0.5;
  std::ofstream(file) << altered.dump();
  CHECK(of(shop.json("session beam.toml" + touch + "-o run2")) == error);
  CHECK(text_of(file) == whole);
  CHECK(shop.json("cache --empty")["foreign"] == 0);
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
  const auto solved = [&](const std::string& more) { return shop.json("solve ball.toml" + more)["states"]; };
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
  CHECK(states[0]["discretisation_error"] == Approx(error).epsilon(0.5));
  CHECK(states[0]["warnings"].empty());
  CHECK(states[1]["discretisation_error"].is_null());
  REQUIRE(states[1]["warnings"].size() == 1);
  CHECK_THAT(states[1]["warnings"][0].get<std::string>(), Contains("from rest only"));
}
