// forefeel show of a body of several materials: each in a colour of its own, with what is inside the body.

#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/phantom.hpp"
#include "tests/apps/shown_page.hpp"
#include "tests/apps/vtk_files.hpp"
#include "tests/support/executable.hpp"

namespace {

struct Groups {
  double inner = 0, end = 0, all = 0;  // volumes [m^3]
};

// The beam with its end as group "end", and tetrahedra around its middle that may lie inside as "inner".
Groups write_beam(const Workshop& shop) {
  TetMesh mesh = phantom("beam", 900);
  const Box box = bounding_box(mesh);
  Groups groups;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    Vec3 centre = Vec3::Zero();
    for (const NodeIndex node : mesh.tets[t]) centre += mesh.nodes[static_cast<std::size_t>(node)] / 4;
    const Vec3 share = (centre - box.low).cwiseQuotient(box.size());
    const double volume = tet_volume(mesh, t);
    groups.all += volume;
    if (share.x() > 0.8) {
      mesh.element_groups["end"].push_back(static_cast<TetIndex>(t));
      groups.end += volume;
    } else if ((share - Vec3(0.5, 0.5, 0.5)).cwiseAbs().maxCoeff() < 0.2) {
      mesh.element_groups["inner"].push_back(static_cast<TetIndex>(t));
      groups.inner += volume;
    }
  }
  REQUIRE(groups.inner > 0);
  write_msh(shop.path() / "beam.msh", mesh);
  shop.write("beam.toml",
             "[body]\nmesh = \"beam.msh\"\n"
             "[[material]]\ngroup = \"inner\"\nlaw = \"neo-hookean\"\nyoung = 5e4\npoisson = 0.3\n"
             "[[material]]\ngroup = \"end\"\nlaw = \"linear\"\nyoung = 2e4\npoisson = 0.3\n"
             "[[material]]\nlaw = \"neo-hookean\"\nyoung = 5e3\npoisson = 0.3\n"
             "[clamp]\ngroup = \"clamp\"\n[contact]\ngroup = \"contact\"\n"
             "[state_space]\nspacing = 0.004\nbox = [[-0.004, -0.004, -0.004], [0.004, 0.004, 0.004]]\n");
  return groups;
}

// Volume that the triangles of one region enclose, by the divergence theorem; the surface is closed.
double enclosed(const json& body, std::size_t region) {
  double volume = 0;
  const auto add = [&](const json& of, auto&& belongs) {
    const auto nodes = floats(of["nodes"]);
    const auto corners = numbers<std::uint32_t>(of["triangles"], "u32");
    const auto its = numbers<std::uint8_t>(of["region"], "u8");
    const auto at = [&](std::uint32_t i) { return Vec3(nodes[3 * i], nodes[3 * i + 1], nodes[3 * i + 2]); };
    for (std::size_t t = 0; t < its.size(); ++t)
      if (belongs(its[t]))
        volume += at(corners[3 * t]).dot(at(corners[3 * t + 1]).cross(at(corners[3 * t + 2]))) / 6;
  };
  add(body, [&](std::size_t k) { return k == region + 1; });
  add(body["inside"], [&](std::size_t k) { return k == region; });
  return volume;
}

}  // namespace

TEST_CASE("show: regions of material have colours, volumes and closed surfaces, in pages and files",
          "[show]") {
  const Workshop shop;
  const Groups groups = write_beam(shop);
  const auto vtu = shop.json("show beam.toml -o beam.vtu");
  REQUIRE(vtu["body"]["regions"].size() == 2);
  CHECK(vtu["body"]["regions"][0]["name"] == "inner");
  CHECK(vtu["body"]["regions"][0]["volume"] == Approx(groups.inner));
  CHECK_THAT(shop.read("beam.vtu"), Contains("Name=\"region\"", "Name=\"region_end\""));
  const auto made = shop.forefeel("show beam.toml -o beam.html --quiet");
  if (made.code == 2) return skip("three.js was not found at build time and is not installed");
  const ShownPage page(shop.path() / "beam.html");
  const auto& body = page.data["body"];
  CHECK(body["regions"][0]["name"] == "inner");
  CHECK(body["regions"][0]["words"] == "neo-hookean, 50 kPa");
  CHECK(body["regions"][1]["name"] == "end");
  CHECK(body["regions"][1]["words"] == "linear, 20 kPa");
  CHECK(body["rest_words"] == "neo-hookean, 5 kPa");
  CHECK(body["regions"][0]["colour"] != body["regions"][1]["colour"]);
  shop.run("show beam.toml -o own.html --quiet --palette '#102030,#405060'");
  const ShownPage own(shop.path() / "own.html");
  CHECK(own.data["body"]["regions"][0]["colour"] == "#102030");
  CHECK(own.data["body"]["regions"][1]["colour"] == "#405060");
  // Positions are 32-bit.
  CHECK(enclosed(body, 0) == Approx(groups.inner).epsilon(1e-4));
  CHECK(enclosed(body, 1) == Approx(groups.end).epsilon(1e-4));
}

TEST_CASE("show: element groups of a mesh are its regions; a body of one material has none", "[show]") {
  const Workshop shop;
  const Groups groups = write_beam(shop);
  const auto mesh = shop.json("show beam.msh -o mesh.vtu");
  REQUIRE(mesh["body"]["regions"].size() == 2);
  CHECK(mesh["body"]["regions"][0]["name"] == "end");
  CHECK(mesh["body"]["regions"][0]["volume"] == Approx(groups.end));
  shop.write("one.toml", beam_scene());
  CHECK(shop.json("show one.toml -o one.vtu")["body"]["regions"].empty());
  check_refused(shop, "show one.toml -o two.vtu --palette mine", {"--palette", "okabe-ito"});
}

TEST_CASE("show: faces where two regions touch belong to the one of fewer elements, whichever comes first",
          "[show]") {
  const Workshop shop;
  for (const bool small_first : {true, false}) {
    TetMesh mesh = phantom("beam", 900);
    const Box box = bounding_box(mesh);
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      const double x = mesh.nodes[static_cast<std::size_t>(mesh.tets[t][0])].x();
      const bool is_end = (x - box.low.x()) / box.size().x() > 0.8;
      mesh.element_groups[is_end == small_first ? "a" : "b"].push_back(static_cast<TetIndex>(t));
    }
    write_msh(shop.path() / "two.msh", mesh);
    if (shop.forefeel("show two.msh -o two.html --quiet").code == 2)
      return skip("three.js was not found at build time and is not installed");
    const ShownPage page(shop.path() / "two.html");
    const std::string small = small_first ? "a" : "b";
    const auto owners = numbers<std::uint8_t>(page.data["body"]["inside"]["region"], "u8");
    REQUIRE_FALSE(owners.empty());
    for (const std::uint8_t owner : owners) CHECK(page.data["body"]["regions"][owner]["name"] == small);
  }
}
