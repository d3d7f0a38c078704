#include <Eigen/Dense>

#include "block_body.hpp"
#include "region_body.hpp"
#include "solver/body/refined_body.hpp"
#include "solver/equilibrium/mesh_error.hpp"
#include "solver/system/discretisation.hpp"
#include "tests/support/test.hpp"

namespace {

// A block on its clamp, pulled or pushed at all of its top; without Poisson's effect it stretches evenly, which
// linear elements represent exactly.
std::shared_ptr<Body> even_block() {
  auto body = std::make_shared<Body>();
  body->mesh = block_mesh(3, 3, 4, Vec3(0.03, 0.03, 0.04));
  body->material = {Law::neo_hookean, 5000, 0.0};
  for (std::size_t i = 0; i < body->mesh.nodes.size(); ++i) {
    if (body->mesh.nodes[i][2] < 1e-9) body->clamp.push_back(static_cast<NodeIndex>(i));
    if (body->mesh.nodes[i][2] > 0.04 - 1e-9) body->contact.push_back(static_cast<NodeIndex>(i));
  }
  return body;
}

// Moved at all of its end: only the edges of clamp and contact are singular.
std::shared_ptr<Body> end_moved(Law law, double poisson, int refine, Element element = Element::linear) {
  auto body = block_body(law, poisson, refine, element);
  body->contact.clear();
  for (std::size_t i = 0; i < body->mesh.nodes.size(); ++i)
    if (body->mesh.nodes[i][0] > 0.1 - 1e-9) body->contact.push_back(static_cast<NodeIndex>(i));
  return body;
}

Mat3 rest_stiffness(const Body& body) {
  return Solver(std::make_shared<const Body>(body)).reference(Vec3::Zero(), 1).state.stiffness;
}

Vec3 force_at(const Body& body, const Vec3& x) {
  return Solver(std::make_shared<const Body>(body)).reference(x, 0.01).state.force;
}

}  // namespace

TEST_CASE("an even stretch has no discretisation error") {
  const std::array at{Vec3(0, 0, -0.004), Vec3(0, 0, 0.006)};
  const MeshError found = mesh_error(even_block(), at, {.spacing = 0.01});
  CHECK(found.method == MeshErrorMethod::equilibria);
  CHECK(found.positions == 2);
  CHECK(found.error < 1e-8);
}

TEST_CASE("the estimate is near the error against a mesh that is refined twice, and below it",
          SLOW("solves meshes that are refined twice")) {
  for (const double poisson : {0.3, 0.45}) {
    const auto body = end_moved(Law::neo_hookean, poisson, 2);
    const std::array at{Vec3(0, 0.006, 0)};
    auto finest = refined(*body);
    finest.element = Element::quadratic;
    const Vec3 truth = force_at(finest, at[0]);
    const double error = (force_at(*body, at[0]) - truth).norm() / truth.norm();
    const MeshError found = mesh_error(body, at, {.spacing = 0.01});
    CAPTURE(poisson, error, found.error);
    REQUIRE(error > 0.02);
    CHECK(found.error > 0.6 * error);
    CHECK(found.error < 1.02 * error);
  }
}

TEST_CASE("refinement shrinks the error, and quadratic elements have less of it",
          SLOW("solves meshes that are refined")) {
  const std::array at{Vec3(0, 0.004, 0.002)};
  const auto error = [&](int refine, Element element) {
    return mesh_error(end_moved(Law::linear, 0.3, refine, element), at, {.spacing = 0.01}).error;
  };
  const double coarse = error(1, Element::linear), fine = error(2, Element::linear),
               finer = error(4, Element::linear), quadratic = error(1, Element::quadratic);
  CAPTURE(coarse, fine, finer, quadratic);
  CHECK(fine < 0.6 * coarse);
  CHECK(finer < 0.6 * fine);
  CHECK(quadratic < 0.5 * coarse);
}

TEST_CASE("by the stiffness at rest: the same for a linear body, and what a large body is measured by") {
  const std::array at{Vec3(0, 0.004, 0.002), Vec3(0.003, 0, 0)};
  const auto body = block_body(Law::linear, 0.4, 2);
  const MeshError whole = mesh_error(body, at, {.spacing = 0.01});
  const MeshError rest = mesh_error(body, at, {.spacing = 0.01, .most_for_equilibria = 10});
  CHECK(rest.method == MeshErrorMethod::rest);
  CHECK(rest.positions == 2);
  CHECK(rest.error == Approx(whole.error).epsilon(1e-8));
  const MeshError none = mesh_error(body, at, {.spacing = 0.01, .most_for_equilibria = 10, .most_nodes = 20});
  CHECK(none.positions == 0);
  CHECK(std::isnan(none.error));
  CHECK_THAT(none.why, Contains("more than 20"));
}

TEST_CASE("nothing to measure at, or asked to stop: not measured, and said so") {
  const auto body = block_body(Law::neo_hookean);
  CHECK_THAT(mesh_error(body, {}, {.spacing = 0.01}).why, Contains("no position"));
  std::stop_source stop;
  stop.request_stop();
  const std::array at{Vec3(0, 0.004, 0)};
  const MeshError stopped = mesh_error(body, at, {.spacing = 0.01, .stop = stop.get_token()});
  CHECK(stopped.stopped);
  CHECK(std::isnan(stopped.error));
}

TEST_CASE(
    "a refined body has the same shape and parts, and is softer: its displacements contain the others") {
  const auto body = region_body({Law::linear, 5e3, 0.4}, {Law::linear, 5e4, 0.3});
  const Body fine = refined(*body);
  CHECK(fine.mesh.tets.size() == 8 * body->mesh.tets.size());
  CHECK(mesh_quality(fine.mesh).volume == Approx(mesh_quality(body->mesh).volume).epsilon(1e-12));
  CHECK(mesh_quality(fine.mesh).min_tet_volume > 0);
  REQUIRE(fine.regions.size() == body->regions.size());
  const auto volume = [](const Body& of) {
    double sum = 0;
    for (const TetIndex tet : of.regions[0].tets) sum += tet_volume(of.mesh, static_cast<std::size_t>(tet));
    return sum;
  };
  CHECK(volume(fine) == Approx(volume(*body)).epsilon(1e-12));
  const Mat3 softer = rest_stiffness(*body) - rest_stiffness(fine);
  CHECK(Eigen::SelfAdjointEigenSolver<Mat3>(0.5 * (softer + softer.transpose())).eigenvalues()[0] > 0);
}

TEST_CASE("the estimated number of nodes is near that of the elements") {
  for (const Element element : {Element::linear, Element::quadratic}) {
    const auto body = block_body(Law::linear, 0.3, 4, element);
    const auto near = [](std::int64_t estimate, std::int64_t nodes) {
      return std::abs(static_cast<double>(estimate - nodes)) < 0.1 * static_cast<double>(nodes);
    };
    CHECK(near(estimated_nodes(*body), discretise(*body).nodes));
    CHECK(near(estimated_nodes_refined(*body), discretise(refined(*body)).nodes));
    CHECK(near(nodes_of_finer(*body), discretise(*finer_body(*body)).nodes));
  }
}
