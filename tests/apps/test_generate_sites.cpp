// generate, export, import and evaluate with sites: scenes with contact.anywhere.

#include "geometry/states/energy_jet.hpp"
#include "geometry/states/state_file.hpp"
#include "tests/support/executable.hpp"

namespace {

// The beam of 10 x 2 x 2 cm, clamped at x = 0. law: linear, or another.
std::string beam(const std::string& law) {
  return "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"" + law +
         "\"\nyoung = 5000.0\npoisson = 0.3\n[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\n"
         "[state_space]\ndepth = 0.004\n";
}

}  // namespace

TEST_CASE("generate makes the field and measures it; of a linear body it is exact",
          SLOW("makes jets at sites over whole surfaces")) {
  const Workshop shop;
  for (const std::string law : {"linear", "neo-hookean"}) {
    shop.write(law + ".toml", beam(law));
    const auto run = shop.run("generate " + law + ".toml -o " + law + ".states --json --error 0.03");
    const json said = run.json();
    CHECK(said["states"] == 400);  // 100 were within the error, so 300 more were looked at
    CHECK(said["solved"] == 400);
    CHECK(said["failed"] == 0);
    const auto p95 = said["error"]["p95"].get<double>();
    CHECK(p95 < (law == "linear" ? 1e-6 : 0.02));
    CHECK(p95 > 0);
    const std::vector<State> states = load_states(shop.path() / (law + ".states")).states;
    CHECK(states.size() == said["sites"].get<std::size_t>() + 400);
    for (const State& state : states) {
      CHECK(state.has_site());
      if (!state.at.isZero()) continue;
      CHECK(state.has_stiffness());
      REQUIRE(state.jet);
      if (law == "linear") CHECK(std::abs(state.jet->coefficients[0]) < 1e-6 * state.stiffness.norm());
    }
    const json again = shop.json("generate " + law + ".toml -o " + law + ".states");
    CHECK(again["solved"] == 0);
    CHECK(again["states"] == 400);
    CHECK(again["field_kept"] == true);
    CHECK(again["error"]["p95"].get<double>() == p95);
  }
  const Workshop::Outcome refused =
      shop.forefeel("generate neo-hookean.toml -o neo-hookean.states --error 1e-7 --json");
  CHECK(refused.code == 1);
  CHECK_THAT(refused.err, Contains("--error 1e-07"));
}

TEST_CASE("evaluate answers at sites; export and import keep them") {
  const Workshop shop;
  shop.write("beam.toml", beam("neo-hookean"));
  shop.run("generate beam.toml -o b.states --where 0.08/0.01/0.02/0.02");
  for (const State& state : load_states(shop.path() / "b.states").states)
    if (!state.at.isZero()) CHECK((state.site - Vec3(0.08, 0.01, 0.02)).norm() <= 0.02);
  shop.write("q.csv", "sx,sy,sz,x,y,z\n0.07,0.008,0.021,0.0005,0.001,-0.003\n");
  const auto run = shop.run("evaluate b.states --scene beam.toml --points q.csv --json");
  const json found = run.json();
  CHECK(found["states"] == 100);
  CHECK(found["error"]["p95"].get<double>() < 0.02);
  const json solved = shop.json("solve beam.toml --site=0.07,0.008,0.021 --at=0.0005,0.001,-0.003");
  double difference = 0, size = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto force = solved["states"][0]["force"][k].get<double>();
    difference += std::pow(force - found["forces"][0][k].get<double>(), 2), size += force * force;
  }
  CHECK(difference < 1e-4 * size);
  shop.run("evaluate b.states --scene beam.toml --points q.csv -o f.csv");
  shop.run("export b.states -o b.csv");
  shop.run("import b.csv -o c.states --spacing 0.01");
  CHECK(load_states(shop.path() / "c.states").states.size() ==
        load_states(shop.path() / "b.states").states.size());
  CHECK(shop.json("evaluate c.states --scene beam.toml --points q.csv")["error"] == found["error"]);
  check_refused(shop, "evaluate b.states --points q.csv", {"--scene", "contact.anywhere"});
  check_refused(shop, "evaluate b.states --scene beam.toml --points q.csv --set material.young=6000",
                {"b.states", "material"});
  check_refused(shop, "generate beam.toml -o d.states --where 0.08/0.01/0.02", {"--where", "x/y/z/radius"});
  check_refused(shop, "generate beam.toml -o d.states --where 0.0/0.01/0.01/0.001", {"--where", "no part"});
}

TEST_CASE("generate --error adds jets and states where the field is not enough; a rerun resumes",
          SLOW("makes jets at sites over whole surfaces")) {
  const Workshop shop;
  shop.write("beam.toml", beam("neo-hookean"));
  const std::string deep = " --where 0.1/0.01/0.01/0.015 --set state_space.depth=0.006";  // the free end
  const json alone = shop.json("generate beam.toml -o a.states" + deep);
  const double p95 = alone["error"]["p95"].get<double>(), wanted = 0.5 * p95;
  CHECK(alone["rounds"] == 0);
  CHECK(alone["error_with_states"]["p95"].is_null());
  const std::string words = "generate beam.toml -o b.states --json --error " + std::to_string(wanted) + deep;
  const Workshop::Outcome run = shop.forefeel(words);
  INFO(run.err);
  const json said = run.json();
  CHECK(said["rounds"].get<int>() >= 1);
  CHECK(said["jets"].get<int>() > 100);
  CHECK(said["solved"].get<int>() > 100);
  REQUIRE(run.code == 0);
  CHECK(said["error_with_states"]["p95"].get<double>() <= wanted);
  const json again = shop.forefeel(words).json();
  CHECK(again["solved"] == 0);
  CHECK(again["states"] == said["states"]);
  CHECK(again["error_with_states"] == said["error_with_states"]);
  State deepest;
  for (const State& state : load_states(shop.path() / "b.states").states)
    if (state.usable() && state.at.norm() > deepest.at.norm()) deepest = state;
  std::string point = "sx,sy,sz,x,y,z\n";
  for (const Vec3& v : {deepest.site, deepest.at})
    for (int k = 0; k < 3; ++k) point += json(v[k]).dump() + ",";
  point.pop_back();
  shop.write("q.csv", point + "\n");
  const json found =
      shop.json("evaluate b.states --scene beam.toml --points q.csv --set state_space.depth=0.006");
  CHECK(found["corrections"].get<int>() > 200);
  for (std::size_t k = 0; k < 3; ++k)
    CHECK(std::abs(found["forces"][0][k].get<double>() - deepest.force[static_cast<int>(k)]) <
          1e-6 * deepest.force.norm());
}
