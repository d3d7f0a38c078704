// The keys that commands print with --json are those that `forefeel help outputs` lists.

#include <fmt/format.h>

#include "apps/main/help_topics.hpp"
#include "tests/support/executable.hpp"
#include "tests/support/json_keys.hpp"

namespace {

void compare(const std::string& table, const std::vector<json>& documents,
             const std::set<std::string>& rare = {}) {
  for (const HelpTopic& topic : help_topics())
    if (topic.name == "outputs") compare_keys(topic.tables, table, documents, rare);
}

}  // namespace

TEST_CASE("help lists the keys of solve, mesh, generate, evaluate and classify --json") {
  const BeamShop shop;
  const auto run = [&](const std::string& words) {
    const auto done = shop.run(words + " --json");
    return done.json();
  };
  shop.write("any.toml",
             "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"linear\"\nyoung = 5000.0\n"
             "poisson = 0.3\n[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\n");
  compare("solve.json", {run("solve beam.toml --at=0,0,0.001 --discretisation-error --jet 4"),
                         run("solve any.toml --site=0.07,0.008,0.021 --at=0,0,-0.001")});
  shop.write("cube.off",
             "OFF\n8 12 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n3 0 2 1\n3 0 3 2\n3 4 5 "
             "6\n3 4 6 7\n"
             "3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n");
  compare("mesh.json",
          {run("mesh --phantom beam -o beam.msh --elements 240"),
           run("mesh cube.off -o cube.msh --elements 300 --length 0.1 --toward 0.05,0.05,0.1,0.02")},
          {"labels[].label", "labels[].name", "labels[].elements", "labels[].volume", "labels[].voxels",
           "labels[].voxel_volume", "labels[].parts", "labels[].touches_border"});
  compare("generate.json", {run("generate beam.toml -o l.states")},
          {"ranks.solving", "ranks.lost", "spacing_auto", "spacing_auto.KEY"});
  shop.write("sq.csv", "sx,sy,sz,x,y,z\n0.07,0.008,0.021,0,0,-0.001\n");
  const std::string depth = " --set state_space.depth=0.002";
  compare("generate_sites.json", {run("generate any.toml -o s.states" + depth)},
          {"ranks.solving", "ranks.lost"});
  compare("evaluate_sites.json", {run("evaluate s.states --scene any.toml --points sq.csv" + depth)});
  compare("generate_error.json", {run("generate beam.toml -o e.states --error 0.1")});
  shop.write("q.csv", "x,y,z\n0.001,0.001,0\n0.002,0,0.001\n");
  std::string measured = "x,y,z,fx,fy,fz\n";
  for (int i = 0; i < 40; ++i) {
    const double x = 1e-4 * (i * 7 % 40), y = 1e-4 * (i * 11 % 40), z = 1e-4 * i;
    measured += fmt::format("{},{},{},{},{},{}\n", x, y, z, -100 * x + 1e-3 * (i % 3), -90 * y, -80 * z);
  }
  shop.write("measured.csv", measured);
  compare("evaluate.json", {run("evaluate l.states --points q.csv"),
                            run("evaluate l.states --points q.csv --method auto --no-bars"),
                            run("evaluate measured.csv --points q.csv")});
  compare("classify.json",
          {run("classify l.states --points q.csv --bars --agreement"),
           run("classify setup:gap --line=-0.03,0,0:0.03,0,0:3 --agreement")},
          {"gaps[].sides", "agreement.worst.KEY"});
}

TEST_CASE("help lists the keys of a session's summary.json") {
  const BeamShop shop;
  const std::string session =
      "session beam.toml --clock virtual --seconds 0.3 --cost constant:0.02 --quiet --json --shape-rate 30 "
      "-o ";
  const auto run = [&](const std::string& words) {
    const auto done = shop.run(session + words);
    return done.json();
  };
  compare("summary.json",
          {run("path --device path:circle,speed=0.03"),
           run("hand --device hand:omega,target=circle,amplitude=0.003 --set state_space.tolerance=0.05")},
          {"spacing_auto.KEY", "field.KEY"});
}
