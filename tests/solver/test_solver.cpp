#include "block_body.hpp"
#include "solver/body/law.hpp"
#include "tests/support/test.hpp"

namespace {

bool same_bits(const State& a, const State& b) {
  return std::memcmp(a.force.data(), b.force.data(), sizeof(Vec3)) == 0 &&
         std::memcmp(a.stiffness.data(), b.stiffness.data(), sizeof(Mat3)) == 0 && a.energy == b.energy;
}

}  // namespace

TEST_CASE(
    "stiffness against central differences of the force, symmetric; energy's gradient is minus the force") {
  for (const Law law : all_laws())
    for (const Element element : {Element::linear, Element::quadratic}) {
      Solver solver(block_body(law, 0.4, 1, element));
      INFO(name(law) << " " << name(element));
      CHECK(check_derivatives(solver, Vec3(-0.012, 0.008, 0.005), 1e-5).solve.residual < 1e-10);
    }
}

TEST_CASE(
    "confined stretch and shear, every node held: force is minus P times the area, stiffness its "
    "derivative") {
  for (const Law law : all_laws()) {
    auto body = std::make_shared<Body>();
    body->mesh = block_mesh(2, 3, 1, Vec3(0.02, 0.03, 0.01));
    body->material = {law, 5000, 0.4};
    for (std::size_t i = 0; i < body->mesh.nodes.size(); ++i)
      (body->mesh.nodes[i][2] > 0.005 ? body->contact : body->clamp).push_back(static_cast<NodeIndex>(i));
    Solver solver(body);
    const Vec3 x(0.002, -0.001, -0.003);
    const State state = solver.reference(x, 0.006).state;
    REQUIRE(state.solve.status == SolveStatus::converged);
    Mat3 f = Mat3::Identity();
    f.col(2) += x / 0.01;
    const LawValue value = evaluate_law(law, law_constants(body->material), f);
    const double area = 0.02 * 0.03;
    CHECK((state.force + area * value.stress.col(2)).norm() < 1e-12 * state.force.norm());
    CHECK(state.energy == Approx(area * 0.01 * value.energy).epsilon(1e-12));
    Mat3 k;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) k(i, j) = area / 0.01 * value.tangent(3 * i + 2, 3 * j + 2);
    CHECK((state.stiffness - k).norm() < 1e-12 * k.norm());
  }
}

TEST_CASE("a state depends on the body and x alone, not on what was solved before") {
  const auto body = block_body(Law::neo_hookean);
  Solver fresh(body), used(body);
  for (const Vec3& x : {Vec3(0.01, 0.02, 0), Vec3(-0.02, 0, 0.01), Vec3(0.9, 0, 0)})
    used.reference(x, 0.006, {.max_iterations = 8});
  const Vec3 x(-0.01, 0.012, 0.004);
  CHECK(same_bits(fresh.reference(x, 0.006).state, used.reference(x, 0.006).state));
}

TEST_CASE("at rest nothing pulls, and from() reaches what reference() does") {
  const auto body = block_body(Law::mooney_rivlin);
  Solver solver(body);
  const State rest = solver.reference(Vec3::Zero(), 0.006).state;
  CHECK(rest.solve.status == SolveStatus::converged);
  CHECK(rest.force.norm() < 1e-12);
  CHECK(rest.energy == Approx(0).margin(1e-15));
  const SolveOutcome near = solver.reference(Vec3(0.006, -0.006, 0), 0.006);
  REQUIRE(near.equilibrium);
  const Vec3 x(0.012, -0.008, 0.003);
  const SolveOutcome direct = solver.from(*near.equilibrium, x, {.want_displacements = true});
  const SolveOutcome tight = solver.reference(x, 0.006);
  CHECK((direct.state.force - tight.state.force).norm() < 1e-9 * tight.state.force.norm());
  REQUIRE(direct.state.displacements);
  CHECK(direct.state.displacements->size() == 3 * body->mesh.nodes.size());
  for (const NodeIndex node : body->contact)
    for (std::size_t i = 0; i < 3; ++i)
      CHECK((*direct.state.displacements)[3 * static_cast<std::size_t>(node) + i] == x[static_cast<int>(i)]);
}

TEST_CASE("a linear body is linear: f = -K x whatever the way, W = x K x / 2") {
  Solver solver(block_body(Law::linear));
  const Mat3 k = solver.reference(Vec3(0.001, 0, 0), 0.006).state.stiffness;
  const Vec3 x(0.03, -0.05, 0.02);
  const State state = solver.reference(x, 0.006).state;
  CHECK(state.solve.status == SolveStatus::converged);
  CHECK((state.force + k * x).norm() < 1e-13 * state.force.norm());
  CHECK(state.energy == Approx(0.5 * x.dot(k * x)).epsilon(1e-12));
}

TEST_CASE("a cancelled solve says so and leaves the solver fit") {
  Solver solver(block_body(Law::neo_hookean));
  std::stop_source stop;
  stop.request_stop();
  const SolveOutcome cancelled = solver.from(*solver.rest(), Vec3(0.01, 0, 0), {}, stop.get_token());
  CHECK(cancelled.state.solve.status == SolveStatus::cancelled);
  CHECK_FALSE(cancelled.equilibrium);
  CHECK(solver.from(*solver.rest(), Vec3(0.01, 0, 0), {}).state.solve.status == SolveStatus::converged);
}

TEST_CASE("what cannot be reached ends with a status, finite or unknown values, never 'converged'") {
  for (const Law law : {Law::neo_hookean, Law::mooney_rivlin, Law::st_venant_kirchhoff}) {
    Solver solver(block_body(law, 0.45));
    const SolveOutcome outcome =
        solver.reference(Vec3(-0.12, 0, 0), 0.02, {.max_iterations = 15});  // through the clamp
    if (outcome.state.solve.status == SolveStatus::converged) {
      CHECK(outcome.state.solve.residual < 1e-7);
      CHECK(outcome.state.force.allFinite());
    } else {
      CHECK_FALSE(outcome.equilibrium);
      CHECK_FALSE(outcome.warnings.empty());
    }
  }
}

TEST_CASE("forces scale with the body: E, size") {
  const Vec3 x(0.01, 0.008, -0.004);
  const auto body = block_body(Law::neo_hookean);
  const State plain = Solver(body).reference(x, 0.006).state;
  for (const double scale : {0.01, 100.0})
    for (const double young : {1.0, 1e9}) {
      auto other = std::make_shared<Body>(*body);
      for (Vec3& node : other->mesh.nodes) node *= scale;
      other->material.young = young;
      const State state = Solver(other).reference(scale * x, scale * 0.006).state;
      REQUIRE(state.solve.status == SolveStatus::converged);
      const double factor = young / 5000 * scale * scale;
      CHECK((state.force - factor * plain.force).norm() < 1e-8 * factor * plain.force.norm());
    }
}

TEST_CASE("bodies that cannot be solved are refused with where and why") {
  const auto good = block_body(Law::neo_hookean);
  CHECK(check(*good, "scene.toml").empty());
  const auto refused = [&](const std::function<void(Body&)>& spoil, const std::string& word) {
    Body body = *good;
    spoil(body);
    CHECK_THAT(error_of([&] { check(body, "scene.toml"); }), Contains(word));
  };
  refused([](Body& b) { b.material.young = -1; }, "young");
  refused([](Body& b) { b.material.poisson = 0.5; }, "poisson");
  refused([](Body& b) { b.material.poisson = std::nan(""); }, "poisson");
  refused([](Body& b) { b.clamp.clear(); }, "clamp");
  refused([](Body& b) { b.contact.clear(); }, "contact");
  refused([](Body& b) { b.contact = {100000}; }, "out of range");
  refused([](Body& b) { b.contact = {b.clamp[0]}; }, "clamped");
  refused(
      [](Body& b) {
        const auto shift = static_cast<NodeIndex>(b.mesh.nodes.size());
        const TetMesh copy = b.mesh;
        for (const Vec3& node : copy.nodes) b.mesh.nodes.push_back(node + Vec3(1, 0, 0));
        for (Tet tet : copy.tets) {
          for (NodeIndex& node : tet) node += shift;
          b.mesh.tets.push_back(tet);
        }
      },
      "parts");
  Body stiff = *good;
  stiff.material.poisson = 0.49;
  CHECK(check(stiff, "scene.toml").size() == 1);
  stiff.element = Element::quadratic;
  CHECK(check(stiff, "scene.toml").empty());
}
