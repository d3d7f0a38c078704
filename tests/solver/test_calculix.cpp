// CalculiX as an oracle: the same block as an input deck. *ELASTIC is the linear law, with NLGEOM it is
// St. Venant-Kirchhoff. The comparison is as exact as the digits that CalculiX prints.
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "block_body.hpp"
#include "tests/support/skip.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace forefeel;

namespace {

void write_deck(const std::filesystem::path& file, const Body& body, const Vec3& x, bool nonlinear) {
  std::ofstream deck(file);
  deck << "*NODE, NSET=ALL\n";
  for (std::size_t i = 0; i < body.mesh.nodes.size(); ++i)
    deck << fmt::format("{}, {:.12e}, {:.12e}, {:.12e}\n", i + 1, body.mesh.nodes[i][0],
                        body.mesh.nodes[i][1], body.mesh.nodes[i][2]);
  deck << "*ELEMENT, TYPE=C3D4, ELSET=BODY\n";
  for (std::size_t i = 0; i < body.mesh.tets.size(); ++i) {
    const Tet& t = body.mesh.tets[i];
    deck << fmt::format("{}, {}, {}, {}, {}\n", i + 1, t[0] + 1, t[1] + 1, t[2] + 1, t[3] + 1);
  }
  const auto set = [&](const char* set_name, const std::vector<NodeIndex>& nodes) {
    deck << "*NSET, NSET=" << set_name << "\n";
    for (const NodeIndex node : nodes) deck << node + 1 << ",\n";
  };
  set("CLAMP", body.clamp);
  set("CONTACT", body.contact);
  deck << fmt::format(
      "*MATERIAL, NAME=M\n*ELASTIC\n{:.12e}, {:.12e}\n*SOLID SECTION, ELSET=BODY, MATERIAL=M\n",
      body.material.young, body.material.poisson);
  deck << "*BOUNDARY\nCLAMP, 1, 3\n";
  deck << (nonlinear ? "*STEP, NLGEOM, INC=200\n*STATIC\n0.1, 1.\n" : "*STEP\n*STATIC\n");
  if (nonlinear) deck << "*CONTROLS, PARAMETERS=FIELD\n1e-9, 1e-9\n";
  deck << "*BOUNDARY\n";
  for (int i = 0; i < 3; ++i) deck << fmt::format("CONTACT, {}, {}, {:.12e}\n", i + 1, i + 1, x[i]);
  deck << "*NODE PRINT, NSET=CONTACT, TOTALS=ONLY, FREQUENCY=200\nRF\n*END STEP\n";
}

// The total reaction on the contact that is printed last.
Vec3 read_total(const std::filesystem::path& file) {
  std::ifstream data(file);
  Vec3 total = Vec3::Constant(std::nan(""));
  for (std::string line; std::getline(data, line);) {
    if (line.find("total force") == std::string::npos) continue;
    std::string values;
    while (std::getline(data, values) && values.find_first_not_of(" \r\t") == std::string::npos) {
    }
    std::istringstream(values) >> total[0] >> total[1] >> total[2];
  }
  return total;
}

}  // namespace

TEST_CASE("CalculiX: the linear law, and St. Venant-Kirchhoff with NLGEOM, within its printed digits") {
  if (!test::has_command("ccx")) return test::skip("calculix-ccx is not installed");
  const test::TemporaryFolder folder;
  for (const Law law : {Law::linear, Law::st_venant_kirchhoff}) {
    const auto body = block_body(law, 0.4);
    const Vec3 x(-0.004, 0.006, 0.003);
    write_deck(folder / "block.inp", *body, x, law != Law::linear);
    const std::string command = "cd '" + folder.path().string() +
                                "' && OMP_NUM_THREADS=1 CCX_NPROC_STIFFNESS=1 ccx block > block.log 2>&1";
    REQUIRE(std::system(command.c_str()) == 0);
    const Vec3 theirs = -read_total(folder / "block.dat");  // they print the force on the body
    REQUIRE(theirs.allFinite());
    const State ours = Solver(body).reference(x, 0.006).state;
    INFO(name(law) << ": " << ours.force.transpose() << ", CalculiX " << theirs.transpose());
    CHECK((ours.force - theirs).norm() < 2e-6 * ours.force.norm());
  }
}
