// Energy jets in commands: solve --jet, state_space.jet, and the files that hold them.

#include <fmt/format.h>

#include "geometry/states/energy_jet.hpp"
#include "geometry/states/state_file.hpp"
#include "tests/support/executable.hpp"

TEST_CASE("solve --jet says the coefficients of its order and the material limit, also in its file") {
  const BeamShop shop;
  for (const int order : {2, 3, 4}) {
    const json state = shop.json("solve beam.toml --at=0.001,0,-0.002 -o out.csv --jet " +
                                 std::to_string(order))["states"][0];
    const json& jet = state["jet"];
    CHECK(jet.size() == jet_terms_of_order(order) + 1);
    const std::vector<State> file = read_states_csv(shop.path() / "out.csv");
    REQUIRE(file[0].jet);
    CHECK(file[0].jet->order == order);
    for (std::size_t i = 0; i < jet_terms_of_order(order); ++i)
      CHECK(jet[jet_names()[i]].get<double>() == file[0].jet->coefficients[i]);
    CHECK(jet["limit"].get<double>() == file[0].jet->limit);
  }
  CHECK(!shop.json("solve beam.toml --at=0,0,0")["states"][0].contains("jet"));
  CHECK(shop.json("solve beam.toml --at=0,0,0 --set state_space.jet=2")["states"][0]["jet"].size() == 11);
  const json linear =
      shop.json("solve beam.toml --at=0,0,0.001 --jet 2 --set material.law=linear")["states"][0]["jet"];
  CHECK(linear["e300"] == 0);
  CHECK(linear["limit"].is_null());
  CHECK_THAT(shop.forefeel("solve beam.toml --at=0,0,-0.001 --jet 4").out,
             Contains("jet of order 4, limit ", " mm"));
  for (const char* order : {"1", "5", "0", "-2", "2.5", "two"}) {
    check_refused(shop, std::string("solve beam.toml --at=0,0,0 --jet=") + order, {"--jet"});
  }
}

TEST_CASE("generate keeps jets of state_space.jet; a rerun with another order resumes the file") {
  const BeamShop shop;
  const std::string generate = "generate beam.toml -o s.states --quiet";
  CHECK(shop.json(generate + " --set state_space.jet=2")["states"] == 27);
  const json info = shop.json("info s.states");
  CHECK(info["with_jet"] == 27);
  CHECK_THAT(shop.forefeel("info s.states").out, Contains("27 with an energy jet"));
  const std::vector<State> states = load_states(shop.path() / "s.states").states;
  for (const State& state : states) {
    REQUIRE(state.jet);
    CHECK(state.jet->order == 2);
    const json solved = shop.json(fmt::format("solve beam.toml --at={},{},{} --jet 2", state.at[0],
                                              state.at[1], state.at[2]))["states"][0]["jet"];
    double largest = 0, off = 0;
    for (std::size_t i = 0; i < jet_terms_of_order(2); ++i) {
      const double e = solved[jet_names()[i]].get<double>();
      largest = std::max(largest, std::abs(e));
      off = std::max(off, std::abs(e - state.jet->coefficients[i]));
    }
    CHECK(off <= 1e-6 * largest);
  }
  const std::string wider = " --set 'state_space.box=[[-0.004,-0.004,-0.004],[0.008,0.004,0.004]]'";
  const json more = shop.json(generate + " --set state_space.jet=4" + wider);
  CHECK(more["resumed"] == 27);
  int orders[5] = {};
  for (const State& state : load_states(shop.path() / "s.states").states) ++orders[state.jet->order];
  CHECK(orders[2] == 27);
  CHECK(orders[4] == 9);
  CHECK(shop.json("generate beam.toml -o plain.states --quiet")["states"] == 27);
  CHECK(shop.json("info plain.states")["with_jet"] == 0);
}

TEST_CASE("files with jets are exported, imported, evaluated and classified as others") {
  const BeamShop shop;
  shop.json("generate beam.toml -o s.states --quiet --threads 1 --set state_space.jet=3");
  shop.json("generate beam.toml -o plain.states --quiet --threads 1");  // the same order of states
  shop.run("export s.states -o s.csv");
  shop.run("import s.csv -o again.states --spacing 0.004");
  const std::vector<State> first = load_states(shop.path() / "s.states").states,
                           again = load_states(shop.path() / "again.states").states;
  REQUIRE(first.size() == again.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    REQUIRE(again[i].jet);
    CHECK(again[i].jet->order == 3);
    CHECK(again[i].jet->coefficients == first[i].jet->coefficients);
    CHECK(again[i].jet->limit == first[i].jet->limit);
  }
  shop.write("q.csv", "x,y,z\n0.001,0.001,0\n0.002,0,0.001\n");
  CHECK(shop.json("evaluate s.states --points q.csv")["forces"] ==
        shop.json("evaluate plain.states --points q.csv")["forces"]);
  CHECK(shop.json("classify s.states --points q.csv")["labels"] ==
        shop.json("classify plain.states --points q.csv")["labels"]);
}

TEST_CASE("a session's states keep jets under both clocks, and a scene with another order is refused") {
  const BeamShop shop("jet = 2\n");
  for (const char* clock : {"virtual", "real"}) {
    const Workshop::Outcome done =
        shop.forefeel(std::string("session beam.toml --seconds 0.5 --quiet --clock ") + clock +
                      " --cost constant:0.02 -o run");
    INFO(done.err);
    REQUIRE(done.code != 2);
    const std::vector<State> states = load_states(shop.path() / "run" / "session.states").states;
    REQUIRE(!states.empty());
    for (const State& state : states) {
      REQUIRE(state.jet);
      CHECK(state.jet->order == 2);
    }
    fs::remove_all(shop.path() / "run");
  }
  shop.write("wrong.toml", beam_scene("jet = 5\n"));
  check_refused(shop, "generate wrong.toml -o w.states", {"state_space.jet", "from 1 to 4"});
}
