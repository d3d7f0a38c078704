// [[material]] tables of a scene: read, checked against the mesh's groups, overridden, kept apart in caches.
#include <fmt/format.h>

#include "apps/scene/scene.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/phantom.hpp"
#include "tests/support/executable.hpp"

namespace {

// beam.msh: the beam with its outer end as group "end", which holds the contact, and "core" in its middle.
void write_beam(const Workshop& shop) {
  TetMesh mesh = phantom("beam", 240);
  const Box box = bounding_box(mesh);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    double centre = 0;
    for (const NodeIndex node : mesh.tets[t]) centre += mesh.nodes[static_cast<std::size_t>(node)][0] / 4;
    const double share = (centre - box.low[0]) / box.size()[0];
    if (share > 0.8) mesh.element_groups["end"].push_back(static_cast<TetIndex>(t));
    if (share > 0.3 && share < 0.5) mesh.element_groups["core"].push_back(static_cast<TetIndex>(t));
    if (share > 0.4) mesh.element_groups["outer half"].push_back(static_cast<TetIndex>(t));
  }
  mesh.element_groups.erase("outer half");
  write_msh(shop.path() / "beam.msh", mesh);
}

std::string scene(const std::string& materials) {
  return "[body]\nmesh = \"beam.msh\"\n" + materials +
         "[clamp]\ngroup = \"clamp\"\n[contact]\ngroup = \"contact\"\n"
         "[state_space]\nspacing = 0.004\nbox = [[-0.004, -0.004, -0.004], [0.004, 0.004, 0.004]]\n";
}

const std::string
    rest = "[[material]]\nlaw = \"neo-hookean\"\nyoung = 5000.0\npoisson = 0.3\n",
    core = "[[material]]\ngroup = \"core\"\nlaw = \"st-venant-kirchhoff\"\nyoung = 5e4\npoisson = 0.4\n";

Scene load(const Workshop& shop, const std::string& text, const std::vector<std::string>& overrides = {},
           const Scene* like = nullptr) {
  return load_scene(shop.write("scene.toml", text), overrides, like);
}

}  // namespace

TEST_CASE("materials of a scene: a group each, and the table without a group for the rest") {
  const Workshop shop;
  write_beam(shop);
  const Scene both = load(shop, scene(core + rest));
  REQUIRE(both.body->regions.size() == 1);
  CHECK(both.body->material.law == Law::neo_hookean);
  CHECK(both.body->regions[0].name == "core");
  CHECK(both.body->regions[0].material.law == Law::st_venant_kirchhoff);
  CHECK(both.body->regions[0].material.young == 5e4);
  CHECK(both.body->regions[0].tets == both.body->mesh.element_groups.at("core"));
  // One table is [material], whether it is written as a list or not.
  const Scene list = load(shop, scene(rest)),
              table = load(shop, scene("[material]\nlaw = \"neo-hookean\"\nyoung = 5000.0\npoisson = 0.3\n"));
  CHECK(list.body->regions.empty());
  CHECK(list.identity == table.identity);
  CHECK(list.identity != both.identity);
}

TEST_CASE("materials: --set reaches each table, by its group or without one") {
  const Workshop shop;
  write_beam(shop);
  const std::string text = scene(core + rest);
  const Scene plain = load(shop, text),
              changed = load(shop, text, {"material.young=6000", "material.core.young=7e4"});
  CHECK(changed.body->material.young == 6000);
  CHECK(changed.body->regions[0].material.young == 7e4);
  CHECK(changed.source.hash != plain.source.hash);
  // A body is shared with another variant only if all its tables are the same.
  const Scene other = load(shop, text, {"material.core.young=7e4"}, &plain);
  CHECK(other.body != plain.body);
  CHECK(other.identity != plain.identity);
  CHECK(load(shop, text, {}, &plain).body == plain.body);
  const auto refused = [&](const std::string& override_text) {
    return error_of([&] { load(shop, text, {override_text}); });
  };
  CHECK_THAT(refused("material.core.young=-1"), Contains("--set material.core.young"));
  CHECK_THAT(refused("material.core=5"), Contains("'material.core' is a table"));
  CHECK_THAT(refused("material.core.yuong=5"), Contains("did you mean 'material.core.young'"));
}

TEST_CASE(
    "materials: what does not fit the mesh is refused in one line with file, line and the names there are") {
  const Workshop shop;
  write_beam(shop);
  const auto refused = [&](const std::string& materials, const std::vector<std::string>& mentions) {
    shop.write("scene.toml", scene(materials));
    check_refused(shop, "solve scene.toml --at=0,0,0.001", mentions);
  };
  const std::string more = "law = \"linear\"\nyoung = 1e4\npoisson = 0.2\n";
  refused(rest + "[[material]]\ngroup = \"cor\"\n" + more,
          {"scene.toml:8: material.cor.group", "'cor'", "core, end", "nearest: 'core'"});
  refused(core, {"scene.toml:3: material.core", "tetrahedra are in none of the groups"});
  refused(rest + rest, {"scene.toml:7: material", "a second table without a group"});
  refused(rest + core + core, {"scene.toml:12: material.core", "a second table of group 'core'"});
  refused(rest + "[[material]]\ngroup = \"end\"\nlaw = \"linear\"\nyoung = 1e4\npoisson = 0.5\n",
          {"scene.toml:11: material.end.poisson", "0.5"});
  shop.write("none.toml", "material = []\n" + scene(""));
  check_refused(shop, "solve none.toml --at=0,0,0.001",
                {"none.toml:1: material", "is a list of 0", "[[material]]"});
  refused("", {"material.law", "missing"});
  shop.write("phantom.toml", "[body]\nphantom = \"beam\"\nelements = 240\n" + core + rest);
  check_refused(shop, "solve phantom.toml --at=0,0,0.001",
                {"phantom.toml:5: material.core.group", "the mesh names none"});
}

TEST_CASE("materials: a table that changes nothing is said") {
  const Workshop shop;
  write_beam(shop);
  TetMesh mesh = read_mesh(shop.path() / "beam.msh");
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    mesh.element_groups["all"].push_back(static_cast<TetIndex>(t));
  mesh.element_groups.erase("core");
  mesh.element_groups.erase("end");
  write_msh(shop.path() / "beam.msh", mesh);
  const Scene all = load(
      shop, scene(rest + "[[material]]\ngroup = \"all\"\nlaw = \"linear\"\nyoung = 1e4\npoisson = 0.2\n"));
  REQUIRE(all.source.warnings.size() == 1);
  CHECK_THAT(all.source.warnings[0], Contains("scene.toml:3: material: without effect"));
  CHECK(is_linear(*all.body));
}

TEST_CASE("materials: states of other materials are not taken for this body's, and info counts the regions") {
  const Workshop shop;
  write_beam(shop);
  shop.write("scene.toml", scene(core + rest));
  shop.run("generate scene.toml -o s.states --quiet");
  shop.run("generate scene.toml -o s.states --quiet");
  check_refused(shop, "generate scene.toml -o s.states --quiet --set material.core.young=4e4",
                {"s.states", "material"});
  const auto info = shop.json("info beam.msh");
  REQUIRE(info["regions"].size() == 2);
  CHECK(info["regions"][0]["name"] == "core");
  CHECK(info["regions"][0]["elements"].get<int>() > 0);
  CHECK(info["regions"][0]["volume"].get<double>() > 0);
  CHECK_THAT(shop.forefeel("info beam.msh").out, Contains("region core: "));
}
