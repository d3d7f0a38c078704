// solve --site: a pad at any place of the surface of a scene with contact.anywhere.

#include "apps/scene/scene_anywhere.hpp"
#include "solver/equilibrium/solver.hpp"
#include "tests/support/executable.hpp"

namespace {

// The beam of 10 x 2 x 2 cm, clamped at x = 0.
const std::string beam =
    "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"neo-hookean\"\nyoung = 5000.0\npoisson "
    "= "
    "0.3\n";
const std::string anywhere = "[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\n";

Vec3 vector_of(const json& list) {
  return {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
}

}  // namespace

TEST_CASE("a site is projected on the surface, and its state is that of a pad at this place") {
  const Workshop shop;
  shop.write("beam.toml", beam + anywhere);
  const auto run =
      shop.run("solve beam.toml --site=0.06,0.008,0.025 --at=0.002,0,-0.006 --at=0,0,-0.003 --json");
  const json states = run.json()["states"];
  REQUIRE(states.size() == 2);
  const Vec3 site = vector_of(states[0]["site"]);
  CHECK((site - Vec3(0.06, 0.008, 0.02)).norm() < 1e-12);
  CHECK(states[0]["clamped_share"] == 0);
  const Scene scene = load_scene_with_sites(shop.path() / "beam.toml", {}, {.spacing = false, .quiet = true});
  REQUIRE(is_anywhere(scene));
  const SitedBody sited = put_at(scene, Vec3(0.06, 0.008, 0.025));
  Solver solver(sited.body);
  const State direct = solver.reference(Vec3(0.002, 0, -0.006), scene.space.spacing).state;
  CHECK((vector_of(states[0]["force"]) - direct.force).norm() < 1e-8 * direct.force.norm());
}

TEST_CASE("sites that cannot be are refused, and a pad that reaches over the clamp is said") {
  const Workshop shop;
  shop.write("beam.toml", beam + anywhere);
  shop.write("plain.toml", beam_scene());
  check_refused(shop, "solve beam.toml --at=0,0,-0.001", {"--site: missing", "X,Y,Z"});
  check_refused(shop, "solve beam.toml --site=0,0.01,0.01 --at=0,0,-0.001", {"--site", "clamped facet"});
  check_refused(shop, "solve beam.toml --site=60,8,20 --at=0,0,-0.001", {"--site", "metres"});
  check_refused(shop, "solve beam.toml --site=0.06,0.008 --at=0,0,-0.001", {"--site"});
  check_refused(shop, "solve beam.toml --site=nan,0,0 --at=0,0,-0.001", {"--site"});
  check_refused(shop, "solve beam.toml --site=0.06,0,0.02 --at=0,0,0 -o out.csv", {"-o", "--json"});
  check_refused(shop, "solve plain.toml --site=0.06,0,0.02 --at=0,0,0", {"--site", "contact.anywhere"});
  const auto run = shop.run("solve beam.toml --site=0.008,0.01,0.02 --at=0,0,-0.002 --json");
  CHECK(run.json()["states"][0]["clamped_share"].get<double>() > 0.01);
  CHECK_THAT(run.err, Contains("reaches over the clamp"));
}

TEST_CASE("keys that say nothing beside contact.anywhere are refused") {
  const Workshop shop;
  const auto refused = [&](const std::string& more, const std::vector<std::string>& mentions) {
    shop.write("beam.toml", beam + anywhere + more);
    check_refused(shop, "solve beam.toml --site=0.06,0,0.02 --at=0,0,0", mentions);
  };
  refused("node = 3\n", {"contact.node"});
  // What a scene of one place says besides is passed over, and said.
  shop.write("beam.toml", beam + anywhere +
                              "nearest = [0.06, 0, 0.02]\n[state_space]\nbox = [[-0.004, -0.005, -0.006], "
                              "[0.004, 0.005, 0.002]]\n");
  const Workshop::Outcome taken = shop.forefeel("solve beam.toml --site=0.06,0,0.02 --at=0,0,0");
  CHECK(taken.code == 0);
  CHECK(taken.err.find("contact.nearest: without effect") != std::string::npos);
  CHECK(taken.err.find("states are placed to its depth, 0.004 m") != std::string::npos);
  refused("[state_space]\ndepth = -0.01\n", {"state_space.depth", "above 0"});
  refused("friction = -0.1\n", {"contact.friction", "at least 0"});
  refused("friction = 0.2\nbonded = true\n", {"contact.bonded", "contact.friction"});
  refused("site_spacing = 0\n", {"contact.site_spacing", "above 0"});
  shop.write("beam.toml", beam + "[contact]\nanywhere = true\n");
  check_refused(shop, "solve beam.toml --site=0.06,0,0.02 --at=0,0,0", {"contact.pad: missing", "anywhere"});
  shop.write("plain.toml", beam_scene());
  check_refused(shop, "solve plain.toml --at=0,0,0 --set state_space.depth=0.01",
                {"state_space.depth", "contact.anywhere"});
  for (const std::string key : {"friction=0.01", "site_spacing=0.01", "bonded=true"})
    check_refused(shop, "solve plain.toml --at=0,0,0 --set contact." + key,
                  {"contact." + key.substr(0, key.find('=')), "contact.anywhere"});
}
