#include <Eigen/Geometry>

#include "block_body.hpp"
#include "solver/body/contact_stiffness.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double radius = 0.01;  // of the patch [m]

// A block ten radii deep and twenty wide, clamped at its bottom; the patch a disc in the middle of its top. Cells of a
// third of the radius under the patch that grow outwards.
std::shared_ptr<Body> deep_block(double poisson, double fine = radius / 3) {
  std::vector<double> half{0};
  for (double step = fine; half.back() < 10 * radius; half.push_back(half.back() + step))
    if (half.back() > 1.4 * radius) step *= 1.4;
  const auto n = static_cast<int>(half.size()) - 1;
  auto body = std::make_shared<Body>();
  body->mesh = block_mesh(2 * n, 2 * n, n, Vec3(2.0 * n, 2.0 * n, n));
  body->material = {Law::linear, 5000, poisson};
  const auto coordinate = [&](double index) {
    return std::copysign(half[static_cast<std::size_t>(std::abs(std::lround(index)))], index);
  };
  for (std::size_t i = 0; i < body->mesh.nodes.size(); ++i) {
    Vec3& x = body->mesh.nodes[i];
    x = Vec3(coordinate(x[0] - n), coordinate(x[1] - n), -coordinate(n - x[2]));
    if (x[2] < -half.back() + 1e-9) body->clamp.push_back(static_cast<NodeIndex>(i));
    if (x[2] > -1e-9 && x.norm() < radius + 1e-9) body->contact.push_back(static_cast<NodeIndex>(i));
  }
  return body;
}

Mat3 solved(const std::shared_ptr<Body>& body) {
  return Solver(body).reference(Vec3::Zero(), 0.01).state.stiffness;
}

}  // namespace

TEST_CASE("The disc's stiffness is that of a patch on a deep block") {
  for (const double poisson : {0.0, 0.3, 0.4}) {
    CAPTURE(poisson);
    const auto body = deep_block(poisson);
    const Mat3 guess = disc_stiffness(*body), truth = solved(body);
    CAPTURE(guess, truth);
    CHECK(guess(2, 2) == Approx(truth(2, 2)).epsilon(0.25));
    CHECK(guess(0, 0) == Approx(truth(0, 0)).epsilon(0.25));
    CHECK(guess(1, 1) == Approx(truth(1, 1)).epsilon(0.25));
  }
}

TEST_CASE("The area of the patch tends to that of the disc") {
  const double disc = 3.14159265358979 * radius * radius;
  double last = 1;
  for (const double cells : {2.0, 4.0, 8.0}) {
    const double off = std::abs(contact_area(*deep_block(0.3, radius / cells)) / disc - 1);
    CAPTURE(cells, off);
    CHECK(off < 1.2 / cells);
    last = off;
  }
  CHECK(last < 0.1);
}

TEST_CASE("The disc's stiffness turns with the body and grows with E and the patch") {
  const auto body = deep_block(0.4);
  const Mat3 before = disc_stiffness(*body);
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
  auto turned = *body;
  for (Vec3& x : turned.mesh.nodes) x = turn * x;
  CHECK((disc_stiffness(turned) - turn * before * turn.transpose()).norm() < 1e-12 * before.norm());
  auto scaled = *body;
  for (Vec3& x : scaled.mesh.nodes) x *= 3;
  scaled.material.young *= 2;
  CHECK((disc_stiffness(scaled) - 6 * before).norm() < 1e-12 * before.norm());
}

TEST_CASE(
    "The disc's stiffness is finite and positive up to incompressible, and zero without a surface to touch") {
  auto body = *deep_block(0.4);
  const double nearly = [&] {
    body.material.poisson = 0.4999;
    return disc_stiffness(body)(2, 2);
  }();
  body.material.poisson = 0.5 - 1e-12;
  CHECK(disc_stiffness(body)(2, 2) == Approx(nearly).epsilon(1e-3));
  for (const double poisson : {-0.99, -0.5, 0.0, 0.499}) {
    body.material.poisson = poisson;
    CHECK(disc_stiffness(body).ldlt().isPositive());
    CHECK(disc_stiffness(body).allFinite());
  }
  // one node within the body
  std::size_t inner = 0;
  while ((body.mesh.nodes[inner] - Vec3(0, 0, -0.05)).norm() > 0.02) ++inner;
  body.contact = {static_cast<NodeIndex>(inner)};
  CHECK(disc_stiffness(body).isZero(0));
}
