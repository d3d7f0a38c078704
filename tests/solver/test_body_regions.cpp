// Bodies of several materials: against exact solutions, differences and tight solves.

#include "geometry/coverage/state_space.hpp"
#include "region_body.hpp"
#include "solver/body/body_digest.hpp"
#include "solver/body/contact_stiffness.hpp"
#include "solver/equilibrium/first_guess.hpp"
#include "solver/equilibrium/linear_body.hpp"
#include "solver/lattice/generate.hpp"
#include "solver/system/discretisation.hpp"
#include "tests/support/test.hpp"

namespace {

const Vec3 there(-0.004, 0.006, 0.003);

bool same_bits(const State& a, const State& b) {
  return std::memcmp(a.force.data(), b.force.data(), sizeof(Vec3)) == 0 &&
         std::memcmp(a.stiffness.data(), b.stiffness.data(), sizeof(Mat3)) == 0 && a.energy == b.energy;
}

std::vector<State> lattice_states(const std::shared_ptr<const Body>& body, int threads) {
  LatticeOptions options;
  options.spacing = 0.006;
  options.box = {Vec3(-0.018, -0.013, -0.012), Vec3(0.024, 0.013, 0.018)};
  options.threads = threads;
  std::vector<State> states;
  const GenerateReport report =
      generate_lattice(body, options, [&](State s) { states.push_back(std::move(s)); });
  CHECK(report.failed == 0);
  return states;
}

struct Pair {
  const char* what;
  Material rest, inclusion;
};

const std::vector<Pair>& pairs() {
  constexpr Law nh = Law::neo_hookean, svk = Law::st_venant_kirchhoff;
  static const std::vector<Pair> all{
      {"10 times stiffer", {nh, 5e3, 0.4}, {nh, 5e4, 0.4}},
      {"1000 times stiffer", {nh, 5e3, 0.4}, {nh, 5e6, 0.4}},
      {"10 times softer", {nh, 5e3, 0.4}, {nh, 5e2, 0.4}},
      {"1000 times softer", {nh, 5e3, 0.4}, {nh, 5, 0.4}},
      {"near-incompressible beside compressible", {nh, 5e3, 0.2}, {Law::mooney_rivlin, 5e3, 0.499}},
      {"another law", {Law::stable_neo_hookean, 5e3, 0.4}, {svk, 2e4, 0.3}},
      {"linear inside", {nh, 5e3, 0.45}, {Law::linear, 5e4, 0.3}}};
  return all;
}

}  // namespace

TEST_CASE("layers of linear elasticity with nu = 0 are springs in series, exactly") {
  for (const Element element : {Element::linear, Element::quadratic}) {
    const auto body = block_body(Law::linear, 0, 1, element);
    body->material = {Law::linear, 5e3, 0};
    body->contact.clear();
    for (std::size_t i = 0; i < body->mesh.nodes.size(); ++i)
      if (body->mesh.nodes[i][0] > 0.1 - 1e-9) body->contact.push_back(static_cast<NodeIndex>(i));
    body->regions = {
        {"stiff", {Law::linear, 5e6, 0}, tets_within(body->mesh, {Vec3(0.04, 0, 0), Vec3(0.06, 1, 1)})},
        {"soft", {Law::linear, 50, 0}, tets_within(body->mesh, {Vec3(0.06, 0, 0), Vec3(0.08, 1, 1)})}};
    CHECK(check(*body, "block").empty());
    const double expected = 0.04 * 0.04 / (0.06 / 5e3 + 0.02 / 5e6 + 0.02 / 50);
    const State state = Solver(body).reference(Vec3(0.001, 0, 0), 0.006).state;
    CHECK(state.stiffness(0, 0) == Approx(expected).epsilon(1e-10));
    CHECK(state.force[0] == Approx(-0.001 * expected).epsilon(1e-10));
    CHECK(linear_basis(body, 0.006)->at(Vec3(0.001, 0, 0), false).force[0] ==
          Approx(-0.001 * expected).epsilon(1e-10));
  }
}

TEST_CASE("regions of one and the same material give the bits of one material, and its identity") {
  for (const Law law : {Law::neo_hookean, Law::linear})
    for (const Element element : {Element::linear, Element::quadratic}) {
      const Material material{law, 5000, 0.4};
      const auto plain = block_body(law, 0.4, 1, element);
      const auto regions = region_body(material, material, &material, 1, element);
      CHECK(same_bits(Solver(plain).reference(there, 0.006).state,
                      Solver(regions).reference(there, 0.006).state));
      CHECK(identity_of(*plain) == identity_of(*regions));
      CHECK(is_linear(*regions) == is_linear(*plain));
    }
}

TEST_CASE("names and order of the regions change neither bits nor identity; a tetrahedron more does") {
  const Material rest{Law::neo_hookean, 5e3, 0.4}, stiff{Law::neo_hookean, 5e4, 0.3},
      end{Law::stable_neo_hookean, 1e4, 0.45};
  const auto body = region_body(rest, stiff, &end), other = region_body(rest, stiff, &end);
  std::swap(other->regions[0], other->regions[1]);
  other->regions[0].name = "renamed";
  CHECK(identity_of(*body) == identity_of(*other));
  CHECK(same_bits(Solver(body).reference(there, 0.006).state, Solver(other).reference(there, 0.006).state));
  other->regions[1].tets.pop_back();
  CHECK(identity_of(*body) != identity_of(*other));
  const auto stiffer = region_body(rest, {Law::neo_hookean, 5.001e4, 0.3}, &end);
  CHECK(identity_of(*body) != identity_of(*stiffer));
  const auto plain = block_body(Law::neo_hookean, 0.4);
  CHECK(identity_of(*body) != identity_of(*plain));
}

TEST_CASE("several materials: force and stiffness are derivatives of energy and force within 1e-5") {
  for (const Pair& pair : pairs())
    for (const Element element : {Element::linear, Element::quadratic}) {
      const auto body = region_body(pair.rest, pair.inclusion, nullptr, 1, element);
      INFO(pair.what << ", " << name(element));
      Solver solver(body);
      const State state = solver.reference(there, 0.006, {.tolerance = 1e-12}).state;
      REQUIRE(state.solve.status == SolveStatus::converged);
      constexpr double step = 1e-5;
      for (int axis = 0; axis < 3; ++axis) {
        const State up = solver.reference(there + step * Vec3::Unit(axis), 0.006, {.tolerance = 1e-12}).state;
        const State down =
            solver.reference(there - step * Vec3::Unit(axis), 0.006, {.tolerance = 1e-12}).state;
        const Vec3 column = -(up.force - down.force) / (2 * step);
        CHECK((column - state.stiffness.col(axis)).norm() < 1e-5 * state.stiffness.norm());
        CHECK(std::abs(-(up.energy - down.energy) / (2 * step) - state.force[axis]) <
              1e-5 * state.force.norm());
      }
    }
}

TEST_CASE("a sweep over several materials is within 1e-6 of tight solves, whatever the threads") {
  for (const Pair& pair : pairs()) {
    const Material end{Law::neo_hookean, 2e4, 0.3};
    const auto body = region_body(pair.rest, pair.inclusion, &end);
    INFO(pair.what);
    const std::vector<State> states = lattice_states(body, 2);
    std::map<std::array<double, 3>, State> alone;
    for (const State& s : lattice_states(body, 1)) alone.emplace(std::array{s.at[0], s.at[1], s.at[2]}, s);
    Solver solver(body);
    double worst = 0;
    for (std::size_t i = 0; i < states.size(); ++i) {
      const State& state = states[i];
      REQUIRE(state.solve.status == SolveStatus::converged);
      REQUIRE(same_bits(state, alone.at({state.at[0], state.at[1], state.at[2]})));
      if (i % 23 != 0 || state.at.norm() == 0) continue;
      const State tight = solver.reference(state.at, 0.006).state;
      REQUIRE(tight.solve.status == SolveStatus::converged);
      worst = std::max(worst, (state.force - tight.force).norm() / tight.force.norm());
    }
    INFO("worst " << worst);
    CHECK(worst < 1e-6);
  }
}

TEST_CASE("each group of eight elements is of one material") {
  const auto body = region_body({Law::neo_hookean, 5e3, 0.4}, {Law::linear, 5e4, 0.3});
  const Discretisation d = discretise(*body);
  REQUIRE(d.elements.materials.size() == 2);
  double volume = 0;
  for (const double v : d.elements.volume) volume += v;
  CHECK(volume == Approx(0.1 * 0.04 * 0.04));
  const MaterialGroups& inside = d.elements.materials[1];
  double its = 0;
  for (std::int64_t i = inside.first * lane_count; i < (inside.first + inside.count) * lane_count; ++i)
    its += d.elements.volume[static_cast<std::size_t>(i)];
  CHECK(its == Approx(0.04 * 0.02 * 0.02));
}

TEST_CASE("a body is linear only if all its materials are; a material without tetrahedra does not count") {
  const auto body = region_body({Law::linear, 5e3, 0.4}, {Law::linear, 5e4, 0.3});
  CHECK(is_linear(*body));
  body->regions[0].material.law = Law::neo_hookean;
  CHECK_FALSE(is_linear(*body));
  CHECK(linear_basis(body, 0.006) == nullptr);
  body->regions[0].material.law = Law::linear;
  body->regions[0].tets = tets_within(body->mesh, {Vec3(0, 0, 0), Vec3(1, 1, 1)});
  body->material = {Law::neo_hookean, -1, 0.7};
  CHECK(is_linear(*body));
  CHECK(materials(*body).size() == 1);
  CHECK(check(*body, "block").empty());
}

TEST_CASE("regions that cannot be solved are refused by name") {
  const auto refused = [](const std::function<void(Body&)>& change) {
    const auto body = region_body({Law::neo_hookean, 5e3, 0.4}, {Law::neo_hookean, 5e4, 0.3});
    change(*body);
    return error_of([&] { check(*body, "block"); });
  };
  CHECK_THAT(refused([](Body& b) { b.regions[0].material.poisson = 0.5; }),
             Contains("material.inclusion.poisson"));
  CHECK_THAT(refused([](Body& b) { b.regions[0].material.young = 0; }), Contains("material.inclusion.young"));
  CHECK_THAT(refused([](Body& b) { b.regions[0].tets.push_back(100000); }),
             Contains("material.inclusion: tetrahedron 100000 is out of range"));
  CHECK_THAT(refused([](Body& b) {
               b.regions.push_back({"twin", {}, {b.regions[0].tets.front()}});
             }),
             Contains("is in 'inclusion' too"));
  CHECK_THAT(refused([](Body& b) {
               b.regions.push_back({"nothing", {}, {}});
             }),
             Contains("material.nothing: no tetrahedron"));
  auto locking = region_body({Law::neo_hookean, 5e3, 0.4}, {Law::neo_hookean, 5e4, 0.49});
  REQUIRE(check(*locking, "block").size() == 1);
  CHECK_THAT(check(*locking, "block")[0], Contains("material.inclusion.poisson = 0.49"));
}

TEST_CASE("the disc takes the material at the patch; the first guess takes them all") {
  const Material soft{Law::neo_hookean, 5e3, 0.4}, stiff{Law::neo_hookean, 5e5, 0.3};
  const auto slab = [&](double from) {
    auto body = std::make_shared<Body>();
    body->mesh = block_mesh(10, 10, 5, Vec3(0.2, 0.2, 0.1));
    body->material = soft;
    body->clamp = nodes_below(body->mesh, Axis::z, 0);
    body->contact = surface_nodes_within(body->mesh, Vec3(0.1, 0.1, 0.1), 0.021);
    if (from > 0)
      body->regions = {{"below", stiff, tets_within(body->mesh, {Vec3(0, 0, 0), Vec3(1, 1, from)})}};
    return body;
  };
  const auto plain = slab(0), deep = slab(0.02), shallow = slab(0.08);
  REQUIRE_FALSE(disc_stiffness(*plain).isZero(0));
  CHECK(disc_stiffness(*deep) == disc_stiffness(*plain));
  const auto stiffness = [](const auto& body) { return first_guess(body).stiffness(2, 2); };
  CHECK(stiffness(deep) > stiffness(plain));
  CHECK(disc_stiffness(*shallow).isZero(0));
  CHECK(stiffness(shallow) > stiffness(deep));
  const auto all = slab(0);
  all->regions = {{"all", stiff, tets_within(all->mesh, {Vec3(0, 0, 0), Vec3(1, 1, 1)})}};
  const auto single = slab(0);
  single->material = stiff;
  CHECK(disc_stiffness(*all) == disc_stiffness(*single));
  CHECK(stiffness(all) == Approx(stiffness(single)).epsilon(1e-12));
}
