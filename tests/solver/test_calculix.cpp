// CalculiX as an oracle: the same blocks as input decks, of one and of several materials. The comparison is as exact as
// the digits that CalculiX prints.

#include "region_body.hpp"
#include "tests/support/calculix.hpp"
#include "tests/support/test.hpp"

namespace {

const Vec3 there(-0.004, 0.006, 0.003);

void check_same(const std::shared_ptr<Body>& body, bool nonlinear, const std::string& what) {
  const TemporaryFolder folder;
  const Vec3 theirs = test::calculix_force(folder.path(), *body, there, nonlinear);
  REQUIRE(theirs.allFinite());
  const State ours = Solver(body).reference(there, 0.006).state;
  INFO(what << ": " << ours.force.transpose() << ", CalculiX " << theirs.transpose());
  CHECK((ours.force - theirs).norm() < 2e-6 * ours.force.norm());
}

}  // namespace

TEST_CASE("CalculiX: the linear law, and St. Venant-Kirchhoff with NLGEOM, within its printed digits",
          SLOW("compares with CalculiX, which only run.sh all installs")) {
  if (!has_command("ccx")) return skip("calculix-ccx is not installed");
  for (const Element element : {Element::linear, Element::quadratic})
    for (const Law law : {Law::linear, Law::st_venant_kirchhoff})
      check_same(block_body(law, 0.4, 1, element), law != Law::linear,
                 std::string(name(law)) + ", " + std::string(name(element)));
}

TEST_CASE(
    "CalculiX: stiff and soft inclusions, factors of 10 and 1000, near-incompressible beside compressible",
    SLOW("compares with CalculiX, which only run.sh all installs")) {
  if (!has_command("ccx")) return skip("calculix-ccx is not installed");
  for (const Law law : {Law::linear, Law::st_venant_kirchhoff}) {
    const Material end{law, 5e4, 0.3};
    for (const double factor : {1e-3, 0.1, 10.0, 1e3})
      check_same(region_body({law, 5e3, 0.4}, {law, factor * 5e3, 0.3}), law != Law::linear,
                 std::string(name(law)) + ", factor " + std::to_string(factor));
    check_same(region_body({law, 5e3, 0.2}, {law, 5e3, 0.499}, &end), law != Law::linear,
               std::string(name(law)) + ", three materials, one of Poisson's ratio 0.499");
  }
}
