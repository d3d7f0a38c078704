// forefeel mesh SCENE --study, run as a person would, with CalculiX on the same meshes as the oracle.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>

#include "geometry/mesh/mesh_file.hpp"
#include "solver/body/refined_body.hpp"
#include "tests/apps/contract.hpp"
#include "tests/solver/block_body.hpp"
#include "tests/support/calculix.hpp"
#include "tests/support/skip.hpp"
#include "tests/support/slow.hpp"

using namespace forefeel;
using nlohmann::json;
using test::check_refused;
using test::run_json;
using test::Workshop;

namespace {

// Two bars of Poisson's ratio 0, one along x, one along y, each clamped at one end; the contact is both other ends, so
// that each bar is pressed and bent. With Poisson's ratio 0 the stress stays finite at the ends' edges, and the forces
// of quadratic elements converge faster than those of linear ones.
std::shared_ptr<Body> write_bars(const Workshop& shop) {
  auto body = std::make_shared<Body>();
  body->material = {Law::neo_hookean, 5e3, 0};
  TetMesh bar = block_mesh(4, 2, 2, Vec3(0.08, 0.04, 0.04));
  for (std::size_t t = 0; t < bar.tets.size(); ++t) {
    // The order of corners decides along which diagonal a refinement cuts; this one keeps the shapes (Bey 1995).
    std::ranges::sort(bar.tets[t]);
    if (tet_volume(bar, t) < 0) std::swap(bar.tets[t][2], bar.tets[t][3]);
  }
  const auto n = static_cast<NodeIndex>(bar.nodes.size());
  body->mesh = bar;
  for (const Vec3& x : bar.nodes) body->mesh.nodes.emplace_back(-0.05 - x[1], x[0], x[2]);
  for (Tet tet : bar.tets) {
    for (NodeIndex& node : tet) node += n;
    body->mesh.tets.push_back(tet);
  }
  for (NodeIndex i = 0; i < 2 * n; ++i) {
    const double along = bar.nodes[static_cast<std::size_t>(i % n)][0];
    if (along < 1e-9) body->clamp.push_back(i);
    if (along > 0.08 - 1e-9) body->contact.push_back(i);
  }
  TetMesh mesh = body->mesh;
  mesh.groups = {{"clamp", body->clamp}, {"contact", body->contact}};
  write_msh(shop.path() / "bars.msh", mesh);
  shop.write("bars.toml",
             "[body]\nmesh = \"bars.msh\"\n[material]\nlaw = \"neo-hookean\"\nyoung = 5000.0\npoisson = 0.0\n"
             "[clamp]\ngroup = \"clamp\"\n[contact]\ngroup = \"contact\"\n"
             "[state_space]\nspacing = 0.004\nbox = [[-0.004, -0.004, -0.004], [0.004, 0.004, 0.004]]\n");
  return body;
}

Vec3 vector_of(const json& list) {
  return {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
}

}  // namespace

TEST_CASE("study: its forces are those of CalculiX on the same meshes, and its rates are the theory's",
          SLOW("compares with CalculiX, which only run.sh all installs")) {
  const Workshop shop;
  const auto body = write_bars(shop);
  const json study = run_json(shop, "mesh bars.toml --study -o study --error 0.05");
  test::check_keys(
      study, {"rows", "at", "force", "beyond", "uncertainty", "rates", "error", "cheapest", "provenance"});
  CHECK(study["rates"]["linear"].get<double>() > 1.5);  // 2 on finer meshes
  CHECK(study["rates"]["linear"].get<double>() < 2.15);
  CHECK(study["rates"]["quadratic"].get<double>() > 2.6);
  CHECK(study["rates"]["quadratic"].get<double>() < 4.1);
  CHECK(study["uncertainty"].get<double>() < 0.005);
  const json& cheapest = study["cheapest"];
  CHECK(cheapest["error"].get<double>() <= 0.05);
  for (const char* file : {"mesh_study.csv", "summary.json"})
    CHECK(std::filesystem::exists(shop.path() / "study" / file));
  if (!test::has_command("ccx")) return test::skip("calculix-ccx is not installed");
  const Vec3 at = vector_of(study["at"]);
  std::vector<Body> levels{*body};
  while (levels.size() < 3) levels.push_back(refined(levels.back()));
  std::size_t compared = 0;
  for (const json& row : study["rows"])
    for (Body level : levels) {
      if (row["elements"] != level.mesh.tets.size() || row["nodes"].get<int>() > 3000) continue;
      level.element = row["element"] == "quadratic" ? Element::quadratic : Element::linear;
      const test::TemporaryFolder folder;
      const double theirs = test::calculix_force(folder.path(), level, at, false).norm(),
                   ours = row["force"].get<double>();
      INFO(row.dump() << ", CalculiX " << theirs);
      CHECK(ours == Approx(theirs).epsilon(2e-6));
      ++compared;
    }
  CHECK(compared >= 5);
}

TEST_CASE(
    "study: the uncertainty is said, an error that no body reaches exits 1, what makes no sense is refused") {
  const Workshop shop;
  write_bars(shop);
  const Workshop::Outcome told = shop.forefeel("mesh bars.toml --study -o study --error 1e-6");
  CHECK(told.code == 1);
  CHECK_THAT(told.out, Catch::Contains("extrapolated force") && Catch::Contains("N, uncertain by"));
  CHECK_THAT(told.err, Catch::Contains("the extrapolated force is uncertain by") &&
                           Catch::Contains("no body that was tried has an error below 0.0001 %"));
  check_refused(shop, "mesh bars.toml --study -o other --elements 100", {"--study"});
  check_refused(shop, "mesh bars.toml --study -o other --unit mm", {"--study"});
  check_refused(shop, "mesh bars.toml -o other.msh --error 0.1", {"--error", "--study"});
}
