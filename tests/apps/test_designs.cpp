// state_space.design: the places of a user and those of the largest estimated error, beside the built-in designs.

#include "geometry/common/csv_rows.hpp"
#include "tests/support/executable.hpp"

namespace {

using Places = std::set<std::array<double, 3>>;

Places places_in(const fs::path& csv) {
  Places places;
  const CsvText table = CsvText::read(csv, "states");
  for (std::size_t i = 0; i < table.rows(); ++i)
    places.insert({table.number(i, "x"), table.number(i, "y"), table.number(i, "z")});
  return places;
}

const std::string mine = " --set 'state_space.design=\"list:mine.csv\"' --quiet";

}  // namespace

TEST_CASE("a listed design: generate solves its places, a session no others, a study compares it") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  shop.write(
      "mine.csv",
      "x,y,z\n0.003,0.001,0\n0,0,0\n-0.002,-0.003,0.0011\n0.0021,0.0022,-0.0023\n-0.004,0.004,0.001\n");
  const Places wanted = places_in(shop.path() / "mine.csv");
  REQUIRE(wanted.size() == 5);
  shop.run("generate beam.toml -o mine.states" + mine);
  shop.run("export mine.states -o solved.csv --quiet");
  CHECK(places_in(shop.path() / "solved.csv") == wanted);
  CHECK(shop.json("generate beam.toml -o mine.states" + mine)["solved"] == 0);

  const json summary = shop.json(
      "session beam.toml --clock virtual --seconds 0.5 --cost constant:0.01 --device "
      "path:circle,speed=0.06,amplitude=0.003 -o run" +
      mine);
  CHECK(summary["states"]["solved"] == 5);
  const Places met = places_in(shop.path() / "run/states.csv");
  CHECK(met == wanted);

  // In a study the file is relative to it, and its content is part of a cell.
  fs::create_directories(shop.path() / "plans");
  shop.write("plans/mine.csv", "x,y,z\n0,0,0\n0.003,0,0\n");
  shop.write(
      "plans/study.toml",
      "scene = \"../beam.toml\"\nseeds = [1]\n[session]\nseconds = 0.2\ndevice = \"path:press,speed=0.05\"\n"
      "[vary]\n\"state_space.design\" = [\"lattice\", \"list:mine.csv\"]\n");
  shop.run("study plans/study.toml -o out --quiet");
  CHECK_THAT(shop.read("out/cells.csv"), Contains("\nlist:mine.csv,1,"));
  CHECK(shop.json("study plans/study.toml -o out")["ran"] == 0);
  shop.write("plans/mine.csv", "x,y,z\n0,0,0\n0.002,0,0\n");
  CHECK(shop.json("study plans/study.toml -o out")["ran"] == 1);
}

TEST_CASE("design = \"error\": generate places as many states as other designs, as --error would begin") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const std::string finer = " --quiet --set state_space.spacing=0.003 --set 'state_space.design=\"error\"'";
  const json placed = shop.json("generate beam.toml -o error.states" + finer);
  CHECK(placed["states"] == 19);  // 8^3 / 3^3
  CHECK(placed["error"].is_null());
  CHECK(placed["error_true"]["samples"] == 0);
  shop.run("export error.states -o error.csv --quiet");
  const Places by_design = places_in(shop.path() / "error.csv");
  shop.forefeel("generate beam.toml --error 1e-7 -o all.states" + finer);
  shop.run("export all.states -o all.csv --quiet");
  const Places until = places_in(shop.path() / "all.csv");
  CHECK(std::ranges::includes(until, by_design));

  check_refused(shop, "session beam.toml --clock virtual --seconds 0.1 -o run" + finer,
                {"state_space.design", "of generate", "another design"});
  check_refused(shop, "generate beam.toml --error 0.01 -o no.states --set 'state_space.design=\"halton\"'",
                {"--error", "\"error\"", "\"halton\""});
}

TEST_CASE("a list that cannot be meant is refused in one line") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  shop.write("outside.csv", "x,y,z\n0,0,0\n0.003,0,0.0041\n");
  shop.write("twice.csv", "x,y,z\n0,0,0\n0.003,0,0\n0.003,0,0\n");
  shop.write("short.csv", "x,y,z\n0,0,0\n0.003,0\n");
  shop.write("empty.csv", "x,y,z\n");
  shop.write("text.csv", "x,y,z\n0,0,rest\n");
  const auto refused = [&](const std::string& design, const std::vector<std::string>& said) {
    check_refused(shop, "generate beam.toml -o no.states --set 'state_space.design=\"" + design + "\"'",
                  said);
  };
  refused("list:none.csv", {"state_space.design", "no such file", "none.csv", "x,y,z"});
  refused("list:outside.csv", {"outside.csv", "place 2", "0.0041", "outside the box", "state_space.box"});
  refused("list:twice.csv", {"twice.csv", "place 3", "place 2", "expected each place once"});
  refused("list:short.csv", {"short.csv:3"});
  refused("list:empty.csv", {"empty.csv", "no points"});
  refused("list:text.csv", {"text.csv:2"});
  refused("list", {"state_space.design", "halton"});
  refused("sobol", {"state_space.design", "sobol", "halton"});
}
