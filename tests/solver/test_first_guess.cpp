#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "block_body.hpp"
#include "geometry/meshing/phantom.hpp"
#include "solver/equilibrium/first_guess.hpp"
#include "tests/support/test.hpp"

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

// Stiffness at rest by central differences of equilibria, which the guess does not go through: no tangent of
// theirs is used.
Mat3 by_differences(const Body& body) {
  auto bent = std::make_shared<Body>(body);
  bent->material.law = Law::neo_hookean;  // of the same stiffness at rest as the linear law
  for (MaterialRegion& region : bent->regions) region.material.law = Law::neo_hookean;
  Solver solver(bent);
  const double step = 1e-5 * longest_side(body.mesh);
  Mat3 stiffness;
  for (int i = 0; i < 3; ++i) {
    const Vec3 x = step * Vec3::Unit(i);
    stiffness.col(i) =
        (solver.reference(-x, step).state.force - solver.reference(x, step).state.force) / (2 * step);
  }
  return stiffness;
}

// How many times stiffer than `truth` a stiffness is, in the directions where that is least and most.
struct Ratio {
  double least, most;
};

Ratio against(const Mat3& truth, const Mat3& stiffness) {
  const Eigen::LLT<Mat3> root(0.5 * (truth + truth.transpose()));
  const Mat3 whitened = root.matrixL().solve(root.matrixL().solve(stiffness).transpose());
  const Eigen::SelfAdjointEigenSolver<Mat3> found(whitened, Eigen::EigenvaluesOnly);
  return {found.eigenvalues()[0], found.eigenvalues()[2]};
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

// A box of `cells` cells along each side of `size`, on its clamp (all of its bottom unless chosen), touched
// from above within `radius` of the middle of its top, or of a point of it.
struct Box3 {
  std::array<int, 3> cells;
  Vec3 size;
  double radius;
  double poisson = 0.4;
  Choose clamped = [](const Vec3& x) { return x[2] < 1e-9; };
  double along = 0.5;  // of the length: where it is touched
};

std::shared_ptr<Body> box(const Box3& of) {
  const Vec3 at(of.along * of.size[0], of.size[1] / 2, of.size[2]);
  return body_of(
      block_mesh(of.cells[0], of.cells[1], of.cells[2], of.size), of.clamped,
      [&](const Vec3& x) { return x[2] > of.size[2] - 1e-9 && (x - at).norm() < of.radius + 1e-9; },
      of.poisson);
}

// A ring of a square section, its lower half clamped or only a short part of it, touched on top.
std::shared_ptr<Body> torus() {
  TetMesh mesh = block_mesh(24, 3, 3, Vec3(1, 0.03, 0.03));
  TetMesh ring = mesh;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const double angle = 1.9 * 3.14159265358979 * mesh.nodes[i][0], r = 0.07 - mesh.nodes[i][1];
    ring.nodes[i] = Vec3(r * std::cos(angle), r * std::sin(angle), mesh.nodes[i][2]);
  }
  return body_of(
      ring, [](const Vec3& x) { return x[2] < 1e-9 && x[0] < -0.03; },
      [](const Vec3& x) { return x[2] > 0.03 - 1e-9 && (x - Vec3(0.055, 0, 0.03)).norm() < 0.016; });
}

std::shared_ptr<Body> phantom_body(const char* name) {
  auto body = std::make_shared<Body>();
  body->mesh = phantom(name);
  body->material = {Law::linear, 5000, 0.45};
  body->clamp = body->mesh.groups.at("clamp");
  body->contact = body->mesh.groups.at("contact");
  return body;
}

struct Tried {
  const char* name;
  std::shared_ptr<Body> body;
};

// Two layers, the upper one a hundred times as stiff.
std::shared_ptr<Body> layered() {
  auto body = std::make_shared<Body>(*box({{6, 6, 6}, Vec3(0.04, 0.04, 0.04), 0.008}));
  MaterialRegion upper{"upper", {Law::linear, 5e5, 0.3}, {}};
  for (std::size_t t = 0; t < body->mesh.tets.size(); ++t) {
    double height = 0;
    for (const NodeIndex node : body->mesh.tets[t])
      height += body->mesh.nodes[static_cast<std::size_t>(node)][2] / 4;
    if (height > 0.03) upper.tets.push_back(static_cast<TetIndex>(t));
  }
  body->regions = {upper};
  return body;
}

std::shared_ptr<Body> quadratic(std::shared_ptr<Body> body) {
  body->element = Element::quadratic;
  return body;
}

std::vector<Tried> tried_bodies() {
  const Vec3 block_size(0.06, 0.06, 0.04), column(0.04, 0.04, 0.08), on_side(0.08, 0.04, 0.04);
  const Choose side = [](const Vec3& x) { return x[0] < 1e-9; };
  return {
      {"block", box({{10, 10, 6}, block_size, 0.0087})},
      {"block, nu 0.3", box({{10, 10, 6}, block_size, 0.0087, 0.3})},
      {"liver", phantom_body("liver")},
      {"ball", phantom_body("ball")},
      {"slab", phantom_body("slab")},
      {"beam", phantom_body("beam")},
      {"cube", box({{6, 6, 6}, Vec3(0.04, 0.04, 0.04), 0.008})},
      {"column 1.5", box({{6, 6, 9}, Vec3(0.04, 0.04, 0.06), 0.008})},
      {"column 2", box({{6, 6, 12}, column, 0.008})},
      {"column 2, all of its end", box({{6, 6, 12}, column, 0.06})},
      {"arm, its end", box({{12, 6, 6}, on_side, 0.008, 0.4, side, 1})},
      {"arm, at three quarters", box({{12, 6, 6}, on_side, 0.008, 0.4, side, 0.75})},
      {"wide patch", box({{9, 9, 6}, block_size, 0.03})},
      {"layer", box({{10, 10, 3}, Vec3(0.06, 0.06, 0.01), 0.012})},
      {"nu 0.49", box({{10, 10, 6}, block_size, 0.0087, 0.49})},
      {"nu 0.49, quadratic", quadratic(box({{5, 5, 3}, block_size, 0.013, 0.49}))},
      {"clamp on one side", box({{8, 8, 6},
                                 Vec3(0.08, 0.08, 0.06),
                                 0.015,
                                 0.4,
                                 [](const Vec3& x) { return x[2] < 1e-9 && x[0] < 0.02; }})},
      {"strip, 4", strip(4, 0.01)},
      {"strip, 10, one node", strip(10, 0.0)},
      {"strip, 40", strip(40, 0.01)},
      {"shell, 3 mm", shell(0.003, 0.006)},
      {"shell, 1 mm", shell(0.001, 0.006)},
      {"torus", torus()},
      {"two layers", layered()},
      {"block, one node", block(6, 0.0)},
  };
}

}  // namespace

TEST_CASE("The first guess is the stiffness at rest of any body, from thin shells to blocks") {
  for (const Tried& tried : tried_bodies()) {
    const FirstGuess guess = first_guess(tried.body);
    CAPTURE(tried.name, guess.left_out);
    REQUIRE(guess.left_out.empty());
    const Ratio ratio = against(by_differences(*tried.body), guess.stiffness);
    CAPTURE(ratio.least, ratio.most);
    CHECK(ratio.least > 0.995);
    CHECK(ratio.most < 1.005);
  }
}

TEST_CASE("A column pulled at all of its end, without Poisson's effect: K = E A / L, which is exact") {
  const Vec3 size(0.04, 0.03, 0.08);
  const auto body = box({{4, 3, 6}, size, 1, 0.0});
  const FirstGuess guess = first_guess(body);
  CHECK(guess.stiffness(2, 2) == Approx(5000 * 0.04 * 0.03 / 0.08).epsilon(1e-9));
  CHECK(std::abs(guess.stiffness(0, 2)) < 1e-9 * guess.stiffness(2, 2));
}

TEST_CASE("A body whose factorisation takes long has no first guess; the note says how large it is") {
  const FirstGuess guess = first_guess(box({{30, 30, 30}, Vec3(0.06, 0.06, 0.06), 0.01}));
  CHECK(guess.stiffness.isZero(0));
  CHECK_THAT(guess.left_out, Contains("29791 nodes"));
}

TEST_CASE("How much softer a body is than a half-space turns and grows with the body") {
  const auto body = block(6, 0.015);
  const double before = first_guess(body).softness;
  CHECK(before > 0.3);
  CHECK(before < 3);  // a block
  CHECK(first_guess(strip(40, 0.01)).softness > 1e4);
  CHECK(std::isnan(first_guess(layered()).softness));  // of two materials at the patch there is no half-space
  auto other = std::make_shared<Body>(*body);
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
  for (Vec3& x : other->mesh.nodes) x = 3 * turn * x;
  other->material.young *= 7;
  CHECK(first_guess(other).softness == Approx(before).epsilon(1e-6));
}
