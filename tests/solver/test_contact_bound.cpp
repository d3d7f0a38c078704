// The bound of a body's stiffness at rest: by hand for one tetrahedron, above every solved stiffness elsewhere.

#include <Eigen/Eigenvalues>

#include "block_body.hpp"
#include "solver/body/contact_stiffness.hpp"
#include "solver/equilibrium/solver.hpp"
#include "tests/support/test.hpp"

namespace {

// A tetrahedron, held at three nodes and touched at the fourth.
std::shared_ptr<Body> one_tetrahedron(double poisson) {
  auto body = std::make_shared<Body>();
  body->mesh.nodes = {Vec3(0, 0, 0), Vec3(0.1, 0, 0), Vec3(0, 0.2, 0), Vec3(0.01, 0.02, 0.1)};
  body->mesh.tets = {{0, 1, 2, 3}};
  body->material = {Law::linear, 5000, poisson};
  body->clamp = {0, 1, 2};
  body->contact = {3};
  return body;
}

Mat3 at_rest(const std::shared_ptr<Body>& body) {
  return Solver(body).reference(Vec3::Zero(), 0.01).state.stiffness;
}

double least_eigenvalue(const Mat3& m) {
  return Eigen::SelfAdjointEigenSolver<Mat3>(0.5 * (m + m.transpose())).eigenvalues()[0];
}

}  // namespace

TEST_CASE("one tetrahedron: uniaxial strain along the height, simple shear across it") {
  // The gradient of the touched node's shape function is (0, 0, 1 / height), wherever above the base it is.
  const double area = 0.5 * 0.1 * 0.2, height = 0.1, e = 5000;
  for (const double poisson : {-0.2, 0.0, 0.3, 0.45}) {
    const Mat3 bound = contact_stiffness_bound(*one_tetrahedron(poisson));
    const double shear = e / (2 * (1 + poisson));
    const double along = e * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson));
    CHECK(bound(2, 2) == Approx(along * area / 3 / height));
    CHECK(bound(0, 0) == Approx(shear * area / 3 / height));
    CHECK(bound(1, 1) == Approx(shear * area / 3 / height));
    CHECK((bound - Mat3(bound.diagonal().asDiagonal())).norm() <= 1e-12 * bound.norm());
  }
}

TEST_CASE("no body is stiffer at rest than its bound, of whatever law, element and materials") {
  for (const Law law : {Law::linear, Law::neo_hookean, Law::stable_neo_hookean, Law::mooney_rivlin})
    for (const Element element : {Element::linear, Element::quadratic}) {
      CAPTURE(static_cast<int>(law), name(element));
      const std::shared_ptr<Body> body = block_body(law, 0.4, 1, element);
      body->regions = {{"inner", {law, 50'000, 0.3}, {40, 41, 42, 43, 44, 45}}};
      const Mat3 solved = at_rest(body), bound = contact_stiffness_bound(*body);
      CHECK(least_eigenvalue(bound - solved) >= -1e-9 * bound.norm());
      CHECK(bound.norm() < 30 * solved.norm());  // and it says something
    }
}
