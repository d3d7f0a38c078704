// Young's modulus and Poisson's ratio mean the same in every law: on ten bodies of a seed the stiffness at rest is that
// of the linear law, and at a small strain the force.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "block_body.hpp"
#include "geometry/states/state_file.hpp"
#include "solver/body/body_digest.hpp"
#include "solver/body/law.hpp"
#include "tests/support/test.hpp"

namespace {

double uniform(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

// A block of any size and direction, clamped at one end and held by nodes of the other.
std::shared_ptr<Body> some_block(std::mt19937& random, double poisson, Element element) {
  const double unit = std::pow(10.0, std::floor(uniform(random, -2, 2)));
  const Vec3 size = unit * Vec3(uniform(random, 0.5, 2), uniform(random, 0.5, 1), uniform(random, 0.5, 1));
  auto body = std::make_shared<Body>();
  body->mesh = block_mesh(3, 2, 2, size);
  for (NodeIndex i = 0; i < body->mesh.nodes.size(); ++i) {
    if (body->mesh.nodes[i][0] < 1e-9 * unit) body->clamp.push_back(i);
    if (body->mesh.nodes[i][0] > size[0] - 1e-9 * unit && body->mesh.nodes[i][1] > 0.4 * size[1])
      body->contact.push_back(i);
  }
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1), 1)
          .normalized();
  for (Vec3& node : body->mesh.nodes) node = turn * node;
  body->material.young = std::pow(10.0, uniform(random, 2, 6));
  body->material.poisson = poisson;
  body->element = element;
  return body;
}

SolveOutcome solved(std::shared_ptr<Body> body, Law law, const Vec3& x) {
  body = std::make_shared<Body>(*body);
  body->material.law = law;
  Solver solver(body);
  const SolveOutcome outcome = solver.reference(x, 1e3);
  REQUIRE(outcome.state.solve.status == SolveStatus::converged);
  return outcome;
}

}  // namespace

TEST_CASE("every law has its young and poisson at small strain") {
  std::mt19937 random(44);
  const double ratios[] = {-0.4, 0.0, 0.05, 0.1, 0.15, 0.1875, 0.3, 0.4, 0.45, 0.49};
  for (int k = 0; k < 10; ++k) {
    const auto body = some_block(random, ratios[k], k % 2 == 0 ? Element::linear : Element::quadratic);
    const Mat3 stiffness = solved(body, Law::linear, Vec3::Zero()).state.stiffness;
    Vec3 press(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
    const double length = longest_side(body->mesh);
    for (const Law law : all_laws()) {
      INFO(name(law) << ", poisson " << ratios[k]);
      const Mat3 own = solved(body, law, Vec3::Zero()).state.stiffness;
      CHECK((own - stiffness).norm() < 1e-8 * stiffness.norm());
      for (const double strain : {1e-5, 1e-4, 1e-3}) {
        const Vec3 x = strain * length * press.normalized();
        const Vec3 linear = solved(body, Law::linear, x).state.force,
                   force = solved(body, law, x).state.force;
        // The mean strain is that; at the corners of the contact it is several times larger.
        CHECK((force - linear).norm() < 5 * strain * linear.norm());
      }
    }
  }
}

TEST_CASE("the form of Mooney-Rivlin is part of a body's identity, and of no other law's") {
  auto body = block_body(Law::mooney_rivlin);
  CHECK(identity_of(*body).at("form of the law") ==
        "mooney-rivlin: 4 (J - 1) beside I2: exact mu and lambda at rest");
  body->regions = {{"inner", {Law::neo_hookean, 5000, 0.3}, {0, 1}}};
  CHECK(identity_of(*body).contains("form of the law"));
  body->material.law = Law::linear;
  CHECK_FALSE(identity_of(*body).contains("form of the law"));
}

// A file of before has no word of the form in its identity, or that of another form.
TEST_CASE("states of the older form of Mooney-Rivlin are refused, with that word") {
  const TemporaryFolder folder;
  const BodyIdentity now = identity_of(*block_body(Law::mooney_rivlin));
  BodyIdentity older = now, other = now;
  older.erase("form of the law");
  other["form of the law"] = "mooney-rivlin: lambda + 4 c2 at rest";
  const auto of = [](const BodyIdentity& identity) {
    return StateFileHeader{.identity = identity, .spacing = 0.004, .box = {}, .notes = {}};
  };
  State state;
  state.solve.status = SolveStatus::converged;
  int n = 0;
  for (const BodyIdentity& of_file : {older, other}) {
    const auto file = folder.path() / fmt::format("{}.states", n++);
    StateFile::open_or_create(file, of(of_file)).append(std::span(&state, 1));
    const std::string error = error_of([&] { StateFile::open_or_create(file, of(now)); });
    CHECK_THAT(error, Contains("form of the law", "exact mu and lambda"));
    CHECK_THAT(error, !Contains("material (") && !Contains("mesh ("));
  }
  CHECK(StateFile::open_or_create(folder.path() / "0.states", of(older)).size() == 1);
}
