// Bodies that are hard to solve: large deformations of a liver up to nu = 0.499, other units, slivers, thin beams, a
// tip beside the clamp, and elements that lock.

#include "block_body.hpp"
#include "geometry/meshing/phantom.hpp"
#include "solver/body/law.hpp"
#include "solver/equilibrium/solver.hpp"
#include "tests/support/test.hpp"

namespace {

std::shared_ptr<Body> phantom_body(const std::string& kind, std::size_t elements) {
  auto body = std::make_shared<Body>();
  body->mesh = phantom(kind, elements);
  body->clamp = body->mesh.groups.at("clamp");
  body->contact = body->mesh.groups.at("contact");
  return body;
}

// An equilibrium, the energy's derivative along the way being the force, whatever the state cost.
void check_solved(const std::shared_ptr<const Body>& body, const Vec3& x, double spacing) {
  Solver solver(body);
  const State s = solver.reference(x, spacing).state;
  INFO(name(body->material.law) << ", nu " << body->material.poisson << ", x " << x.transpose());
  REQUIRE(s.solve.status == SolveStatus::converged);
  CHECK(s.solve.residual < 1e-8);
  const Vec3 step = 1e-4 * x;
  const double up = solver.reference(x + step, spacing).state.energy,
               down = solver.reference(x - step, spacing).state.energy;
  CHECK(-s.force.dot(2 * step) == Approx(up - down).epsilon(1e-5));
}

}  // namespace

TEST_CASE(
    "a liver pressed, pulled and sheared by centimetres, up to nu = 0.499: where the mesh allows, an "
    "equilibrium",
    SLOW("solves far into the range where steps are small")) {
  for (const double poisson : {0.3, 0.45, 0.49, 0.499}) {
    const auto body = phantom_body("liver", 600);
    body->material.poisson = poisson;
    for (const Law law : {Law::neo_hookean, Law::mooney_rivlin}) {  // which refuse inverted elements
      body->material.law = law;
      for (const Vec3& x : {Vec3(0, 0, -0.06), Vec3(0, 0, 0.06), Vec3(0.04, 0, 0)})
        check_solved(body, x, 0.006);
    }
  }
}

TEST_CASE("slivers of a degree, a beam a fifth as thick, a tip beside the clamp: an equilibrium",
          SLOW("solves far into the range where steps are small")) {
  const auto flat = phantom_body("liver", 600);
  for (int times = 0; mesh_quality(flat->mesh).min_dihedral_deg > 1 && times < 30; ++times)
    for (Vec3& node : flat->mesh.nodes) node[2] *= 0.8;
  REQUIRE(mesh_quality(flat->mesh).min_dihedral_deg < 1);
  check_solved(flat, Vec3(0, 0, 0.001), 0.001);

  const auto thin = phantom_body("beam", 0);
  for (Vec3& node : thin->mesh.nodes) node[2] *= 0.2;
  check_solved(thin, Vec3(0, 0, 0.03), 0.003);

  const auto beside = phantom_body("beam", 0);
  double least = std::numeric_limits<double>::infinity();
  for (const NodeIndex node : surface_nodes(beside->mesh))
    for (const NodeIndex held : beside->clamp) {
      const double distance = (beside->mesh.nodes[static_cast<std::size_t>(node)] -
                               beside->mesh.nodes[static_cast<std::size_t>(held)])
                                  .norm();
      if (distance >= least || std::ranges::binary_search(beside->clamp, node)) continue;
      least = distance;
      beside->contact = {node};
    }
  check_solved(beside, 0.9 * least * Vec3(0.6, 0.6, 0.53), 0.001);
}

TEST_CASE("linear tetrahedra lock as nu tends to 1/2, quadratic ones do not",
          SLOW("solves meshes that are refined three times")) {
  const auto over_truth = [](double poisson, Element element, int refine) {
    const auto force = [&](Element kind, int times) {
      return Solver(block_body(Law::neo_hookean, poisson, times, kind))
          .reference(Vec3(0, -0.006, 0), 0.006)
          .state.force.norm();
    };
    return force(element, refine) / force(Element::quadratic, 3);
  };
  const double linear = over_truth(0.3, Element::linear, 1),
               quadratic = over_truth(0.3, Element::quadratic, 1);
  CHECK(over_truth(0.499, Element::linear, 1) > 1.5 * linear);
  CHECK(over_truth(0.499, Element::quadratic, 1) == Approx(quadratic).epsilon(0.06));
  for (const double poisson : {0.3, 0.45, 0.49, 0.499}) {
    const double coarse = over_truth(poisson, Element::quadratic, 1),
                 fine = over_truth(poisson, Element::linear, 2);
    CAPTURE(poisson, coarse, fine);
    CHECK(coarse > 1);
    CHECK(coarse < 1.3);
    CHECK(fine > coarse + 0.1);  // though it has twice as many nodes along each edge
  }
}
