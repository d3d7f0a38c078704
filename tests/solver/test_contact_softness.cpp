#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "block_body.hpp"
#include "solver/body/contact_softness.hpp"
#include "solver/body/contact_stiffness.hpp"

namespace forefeel {
namespace {

using Choose = std::function<bool(const Vec3&)>;

std::shared_ptr<Body> body_of(TetMesh mesh, const Choose& clamped, const Choose& touched,
                              double poisson = 0.4) {
  auto body = std::make_shared<Body>();
  body->mesh = std::move(mesh);
  body->material = {Law::linear, 5000, poisson};
  for (std::size_t i = 0; i < body->mesh.nodes.size(); ++i) {
    const Vec3& x = body->mesh.nodes[i];
    if (clamped(x)) body->clamp.push_back(static_cast<NodeIndex>(i));
    if (touched(x) && !clamped(x)) body->contact.push_back(static_cast<NodeIndex>(i));
  }
  return body;
}

// How many times stiffer than the body the disc is, in the direction where that is worst.
double too_stiff(const std::shared_ptr<Body>& body) {
  const Mat3 truth = Solver(body).reference(Vec3::Zero(), 0.01).state.stiffness;
  const Mat3 disc = disc_stiffness(*body);
  const Eigen::LLT<Mat3> root(0.5 * (truth + truth.transpose()));
  const Mat3 whitened = root.matrixL().solve(root.matrixL().solve(disc).transpose());
  return Eigen::SelfAdjointEigenSolver<Mat3>(whitened).eigenvalues()[2];
}

std::shared_ptr<Body> block(int cells, double radius) {  // 6 x 6 x 4 cm on its clamp, touched from above
  return body_of(
      block_mesh(cells, cells, cells * 2 / 3, Vec3(0.06, 0.06, 0.04)),
      [](const Vec3& x) { return x[2] < 1e-9; },
      [=](const Vec3& x) {
        return x[2] > 0.04 - 1e-9 && (x - Vec3(0.03, 0.03, 0.04)).norm() < radius + 1e-9;
      });
}

// A strip of a square section, clamped at one end and touched at the other one's top.
std::shared_ptr<Body> strip(int slenderness, double patch) {
  constexpr double side = 0.01;
  const double length = side * slenderness;
  return body_of(
      block_mesh(2 * slenderness, 2, 2, Vec3(length, side, side)), [](const Vec3& x) { return x[0] < 1e-9; },
      [=](const Vec3& x) { return x[0] > length - patch - 1e-9 && x[2] > side - 1e-9; });
}

// A plate of 10 x 10 cm, bent to an arch, clamped at its rim.
std::shared_ptr<Body> shell(double thickness, double radius) {
  TetMesh mesh = block_mesh(20, 20, 2, Vec3(0.1, 0.1, thickness));
  for (Vec3& x : mesh.nodes) x -= Vec3(0.05, 0.05, 0);
  const double rim = 0.05 - 1e-9;
  std::vector<bool> top(mesh.nodes.size()), edge(mesh.nodes.size());
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    Vec3& x = mesh.nodes[i];
    top[i] = x[2] > thickness - 1e-9 && std::hypot(x[0], x[1]) < radius + 1e-9;
    edge[i] = std::abs(x[0]) > rim || std::abs(x[1]) > rim;
    x[2] += 0.02 * std::cos(x[0] / 0.05 * 1.2) * std::cos(x[1] / 0.05 * 1.2);
  }
  auto body = std::make_shared<Body>();
  body->mesh = std::move(mesh);
  body->material = {Law::linear, 5000, 0.4};
  for (std::size_t i = 0; i < top.size(); ++i) {
    if (edge[i]) body->clamp.push_back(static_cast<NodeIndex>(i));
    if (top[i] && !edge[i]) body->contact.push_back(static_cast<NodeIndex>(i));
  }
  return body;
}

}  // namespace

TEST_CASE("On a block about its patch the first guess is kept, and is no more than four times too stiff") {
  for (const int cells : {6, 12})
    for (const double radius : {0.0, 0.008, 0.015}) {
      CAPTURE(cells, radius, contact_softness(*block(cells, radius)));
      CHECK(contact_softness(*block(cells, radius)) <= most_softness);
      CHECK(too_stiff(block(cells, radius)) < 4);
    }
}

TEST_CASE("On a slender strip and a thin shell the first guess is left out: it is far too stiff there") {
  for (const int slenderness : {4, 10, 40})
    for (const double patch : {0.0, 0.01}) {
      CAPTURE(slenderness, patch, contact_softness(*strip(slenderness, patch)));
      CHECK(too_stiff(strip(slenderness, patch)) > 8);
      CHECK(contact_softness(*strip(slenderness, patch)) > most_softness);
    }
  for (const double thickness : {0.001, 0.003}) {
    CAPTURE(thickness, contact_softness(*shell(thickness, 0.006)));
    CHECK(too_stiff(shell(thickness, 0.006)) > 8);
    CHECK(contact_softness(*shell(thickness, 0.006)) > most_softness);
  }
}

TEST_CASE("A block on the end of a thin handle is as soft as the handle") {
  TetMesh mesh = block_mesh(24, 6, 6, Vec3(0.12, 0.03, 0.03));  // a third of it a block, the rest a handle
  for (Vec3& x : mesh.nodes)
    if (x[0] < 0.08 - 1e-9)
      for (int i = 1; i < 3; ++i) x[i] = 0.015 + 0.2 * (x[i] - 0.015);
  const auto body = body_of(
      mesh, [](const Vec3& x) { return x[0] < 1e-9; },
      [](const Vec3& x) { return x[2] > 0.03 - 1e-9 && (x - Vec3(0.1, 0.015, 0.03)).norm() < 0.006; });
  CAPTURE(contact_softness(*body));
  CHECK(too_stiff(body) > 8);
  CHECK(contact_softness(*body) > most_softness);
}

TEST_CASE("The estimate of the softness turns and grows with the body and ends with its clamp") {
  const auto body = block(6, 0.015);
  const double before = contact_softness(*body);
  auto other = *body;
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
  for (Vec3& x : other.mesh.nodes) x = 3 * turn * x;
  other.material.young *= 7;
  CHECK(contact_softness(other) == Approx(before).epsilon(1e-6));
  other.clamp.clear();
  CHECK(std::isinf(contact_softness(other)));
}
}  // namespace forefeel
