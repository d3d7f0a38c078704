// The stiffness at rest under a pad anywhere, against a solve of the body with the pad there.
#include <Eigen/Geometry>

#include "pad_body.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/system/site_stiffness.hpp"
#include "tests/support/test.hpp"

namespace {

double difference(const std::shared_ptr<Body>& body, SiteStiffness& anywhere, const Vec3& place) {
  body->pad->site = nearest_site(body->mesh, place);
  const Mat3 solved = Solver(body).reference(Vec3::Zero(), 0.006).state.stiffness;
  return (anywhere.at(body->pad->site) - solved).norm() / solved.norm();
}

}  // namespace

TEST_CASE("The stiffness at rest of any site follows from the body without a contact") {
  for (const Element element : {Element::linear, Element::quadratic}) {
    const auto body = padded_phantom("liver", 600, phantom_tip("liver"), Law::mooney_rivlin, element);
    SiteStiffness anywhere(*body);
    CHECK(anywhere.known_nodes() == 0);
    const Vec3 tip = phantom_tip("liver");
    CHECK(difference(body, anywhere, tip) < 1e-9);
    const std::size_t first = anywhere.known_nodes();
    CHECK(first > 0);
    CHECK(difference(body, anywhere, tip + Vec3(0.005, 0, 0)) < 1e-9);
    CHECK(anywhere.known_nodes() < 2 * first);
    // also where the pad stands partly on the clamp
    CHECK(difference(body, anywhere, body->mesh.nodes[body->clamp.front()] + Vec3(0, 0, 0.01)) < 1e-9);
  }
}

TEST_CASE("A body without a pad has no stiffness of sites") {
  CHECK_THROWS_WITH(SiteStiffness(*gripped_phantom("ball", 300)), Contains("expected a body with a pad"));
}
