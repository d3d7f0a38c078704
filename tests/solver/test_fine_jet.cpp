// The difference of a fine and a coarse body's rest jets, and bodies that contain it.
#include <Eigen/Eigenvalues>

#include "geometry/coverage/state_space.hpp"
#include "pad_body.hpp"
#include "solver/body/fine_jet.hpp"
#include "solver/body/refined_body.hpp"
#include "solver/jet/rest_jet.hpp"
#include "solver/lattice/generate.hpp"
#include "tests/support/test.hpp"

namespace {

// A difference whose degrees are about equal at 1 cm.
FineJet some_fine_jet() {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  RestJet fine, coarse;
  for (int i = 0; i < 3; ++i)
    for (int k = i; k < 3; ++k) fine.stiffness(i, k) = fine.stiffness(k, i) = 100 * uniform(random);
  coarse.stiffness = 200 * Mat3::Identity();
  fine.jet.order = coarse.jet.order = 4;
  for (std::size_t i = 0; i < jet_size; ++i) {
    const double scale = i < 10 ? 3e3 : i < 25 ? 3e5 : 3e7;
    fine.jet.coefficients[i] = scale * uniform(random);
    coarse.jet.coefficients[i] = 0.5 * scale * uniform(random);
  }
  return {fine, coarse, "some body"};
}

// The quadratic body of eight times as many tetrahedra.
Body fine_of(const Body& body) {
  Body fine = refined(body);
  fine.element = Element::quadratic;
  return fine;
}

// The body with the difference of the fine body's jet and its own.
std::shared_ptr<Body> with_fine(const std::shared_ptr<Body>& body) {
  const Body fine = fine_of(*body);
  auto corrected = std::make_shared<Body>(*body);
  corrected->fine =
      std::make_shared<const FineJet>(rest_jet(fine, {}), rest_jet(*body, {}), fine_body_in_words(fine));
  return corrected;
}

std::vector<Vec3> positions_of(double radius) {
  std::vector<Vec3> list;
  for (const Vec3& way : {Vec3(1, 0, 0), Vec3(0.3, -0.8, 0.5), Vec3(-0.6, -0.2, -0.7)})
    for (const double t : {0.1, 0.5, 0.79, 0.8, 0.81, 0.95, 1.0, 1.1, 1.5, 3.0})
      list.push_back(t * radius * way.normalized());
  return list;
}

}  // namespace

TEST_CASE("The fine jet's gradient and Hessian are its energy's, within its radius, across and beyond") {
  const FineJet jet = some_fine_jet();
  REQUIRE(std::isfinite(jet.radius()));
  CHECK(jet.radius() > 0.0005);
  CHECK(jet.radius() < 0.05);
  const double h = 1e-4 * jet.radius();
  for (const Vec3& x : positions_of(jet.radius())) {
    CAPTURE(x.norm() / jet.radius());
    const JetTerms at = jet.at(x);
    Vec3 gradient;
    Mat3 hessian;
    for (int i = 0; i < 3; ++i) {
      const JetTerms up = jet.at(x + h * Vec3::Unit(i)), down = jet.at(x - h * Vec3::Unit(i));
      gradient[i] = (up.energy - down.energy) / (2 * h);
      hessian.col(i) = (up.gradient - down.gradient) / (2 * h);
    }
    CHECK((at.gradient - gradient).norm() < 1e-6 * (gradient.norm() + jet.stiffness().norm() * jet.radius()));
    CHECK((at.hessian - hessian).norm() < 1e-6 * (hessian.norm() + jet.stiffness().norm()));
    CHECK((at.hessian - at.hessian.transpose()).norm() < 1e-14 * at.hessian.norm());
  }
}

TEST_CASE("The fine jet is its polynomial to 0.8 of its radius and bounded beyond") {
  const FineJet jet = some_fine_jet();
  EnergyJet at_rest{.order = 4};
  jet.add_to(at_rest, Vec3::Zero());
  for (const Vec3& x : positions_of(jet.radius())) {
    const double polynomial = jet_terms(at_rest, x).energy + 0.5 * x.dot(jet.stiffness() * x);
    if (x.norm() <= 0.8 * jet.radius())
      CHECK(jet.at(x).energy == Approx(polynomial).epsilon(1e-12));
    else if (x.norm() > 0.9 * jet.radius())
      CHECK(std::abs(jet.at(x).energy - polynomial) > 1e-6 * std::abs(polynomial));
  }
  const auto most = [&](double t) {
    double energy = 0, force = 0;
    for (const Vec3& x : positions_of(1)) {
      const JetTerms at = jet.at(t * jet.radius() * x.normalized());
      energy = std::max(energy, std::abs(at.energy));
      force = std::max(force, at.gradient.norm());
    }
    return std::pair(energy, force);
  };
  const auto [energy, force] = most(1);
  for (const double t : {1.5, 3.0, 10.0, 1000.0}) {
    CHECK(most(t).first < 3 * energy);
    CHECK(most(t).second < 3 * force);
  }
  CHECK(most(1000).second < 0.01 * force);
}

TEST_CASE("The radius is where a degree of the force reaches its share of the linear force") {
  RestJet fine, coarse;
  fine.stiffness = 10 * Mat3::Identity();
  fine.jet.order = coarse.jet.order = 4;
  const auto trusted = [&] { return FineJet::trusted_share * FineJet(fine, coarse, "").radius(); };
  CHECK(std::isinf(trusted()));
  const double c3 = 40, c4 = 1e5, c5 = 1e8;
  // root mean squares over the sphere of 3 c x^2, 4 c r^3 and 5 c z^4: of x^4 1/5, of z^8 1/9
  fine.jet.coefficients[jet_index(3, 0, 0)] = c3;
  CHECK(trusted() == Approx(10 / (3 * c3 * std::sqrt(1.0 / 5))).epsilon(0.01));
  for (const auto& [a, b, c] : {std::array{4, 0, 0}, std::array{0, 4, 0}, std::array{0, 0, 4}})
    fine.jet.coefficients[jet_index(a, b, c)] = c4;
  for (const auto& [a, b, c] : {std::array{2, 2, 0}, std::array{2, 0, 2}, std::array{0, 2, 2}})
    fine.jet.coefficients[jet_index(a, b, c)] = 2 * c4;
  CHECK(trusted() == Approx(std::sqrt(0.2 * 10 / (4 * c4))).epsilon(0.01));
  fine.jet.coefficients[jet_index(0, 0, 5)] = c5;
  CHECK(trusted() == Approx(std::cbrt(0.03 * 10 / (5 * c5 * std::sqrt(1.0 / 9)))).epsilon(0.01));
}

TEST_CASE("Where the fine jet saturates a stable body stays stable") {
  for (const char* phantom : {"liver", "slab"}) {
    const auto body = padded_phantom(phantom, 600, phantom_tip(phantom));
    const auto corrected = with_fine(body);
    Solver plain(body), solver(corrected);
    const double radius = corrected->fine->radius();
    const Vec3 inward = -pad_surface(body->mesh, *body->pad).normal, side = inward.unitOrthogonal();
    for (const double share : {0.7, 0.9, 1.1, 1.6})
      for (const Vec3& way : {inward, Vec3(-inward), side, Vec3((inward + side).normalized())}) {
        const Vec3 x = share * radius * way;
        const State coarse = plain.reference(x, 0.006).state, state = solver.reference(x, 0.006).state;
        const auto least = [](const State& s) {
          return Eigen::SelfAdjointEigenSolver<Mat3>(s.stiffness).eigenvalues()[0];
        };
        if (!coarse.usable() || least(coarse) < 0) continue;  // past a limit point of the body itself
        REQUIRE(state.usable());
        INFO(phantom << ", " << share << " of the radius " << radius << " along " << way.transpose());
        CHECK(least(state) >= 0);
      }
  }
}

TEST_CASE("A state's jet takes the Taylor coefficients of the fine jet at its place") {
  const FineJet fine = some_fine_jet();
  const Vec3 way = Vec3(0.4, -0.5, 0.8).normalized();
  for (const Vec3& x : positions_of(fine.radius())) {
    const double t = x.norm() / fine.radius();
    // the series does not reach across the place where the argument begins to saturate
    if (std::abs(t - 0.8) < 0.02) continue;
    CAPTURE(t);
    const JetTerms at = fine.at(x);
    for (int order = 2; order <= 4; ++order) {
      EnergyJet jet{.order = order};
      fine.add_to(jet, x);
      for (std::size_t i = jet_terms_of_order(order); i < jet_size; ++i) CHECK(jet.coefficients[i] == 0);
      // the remainder of the force, even and odd parts together
      const auto remainder = [&](double distance) {
        double square = 0;
        for (const double sign : {1.0, -1.0}) {
          const Vec3 d = sign * distance * way;
          square += (fine.at(x + d).gradient - at.gradient - at.hessian * d - jet_terms(jet, d).gradient)
                        .squaredNorm();
        }
        return std::sqrt(square);
      };
      const double size = at.gradient.norm() + fine.stiffness().norm() * fine.radius();
      const double h = 0.004 * fine.radius(), near = remainder(h), far = remainder(2 * h);
      if (near < 1e-13 * size)
        CHECK(far < 1e-12 * size);  // the polynomial itself
      else
        CHECK(std::log2(far / near) > order + 0.8);
    }
  }
}

TEST_CASE("A body with a fine jet: the energy's gradient is minus the force, the stiffness the force's") {
  for (const Law law : {Law::neo_hookean, Law::st_venant_kirchhoff})
    for (const bool padded : {true, false}) {
      const auto body = with_fine(padded ? padded_block(law) : block_body(law));
      const double radius = body->fine->radius();
      INFO(name(law) << (padded ? ", pad" : ", rigid") << ", radius " << radius);
      Solver solver(body);
      for (const double share : {0.4, 0.9, 1.3}) {
        const Vec3 x = std::min(share * radius, 0.012 * share) * Vec3(0.5, 0.4, -0.9).normalized();
        check_derivatives(solver, x, 1e-5, {.tolerance = 1e-12});
      }
    }
}

TEST_CASE("At rest a body with a fine jet is the fine body: stiffness and jet") {
  const auto coarse = padded_block(Law::neo_hookean);
  const RestJet truth = rest_jet(fine_of(*coarse), {}), corrected = rest_jet(*with_fine(coarse), {});
  CHECK((corrected.stiffness - truth.stiffness).norm() < 1e-12 * truth.stiffness.norm());
  for (std::size_t i = 0; i < jet_size; ++i)
    CHECK(corrected.jet.coefficients[i] == Approx(truth.jet.coefficients[i])
                                               .epsilon(1e-9)
                                               .margin(i < 10   ? 1e-6
                                                       : i < 25 ? 1e-4
                                                                : 1e-2));
}

TEST_CASE("With a fine jet the force of order p errs as |d|^(p + 1)") {
  const auto body = with_fine(padded_block(Law::neo_hookean));
  Solver solver(body);
  const SolveOptions exact{.tolerance = 1e-12};
  const double radius = body->fine->radius();
  CAPTURE(radius);
  const Vec3 way = Vec3(0.3, -0.2, -1).normalized();
  for (const Vec3& x : {Vec3(0, 0, 0), Vec3(0.3 * radius * way), Vec3(0.95 * radius * way)}) {
    const SolveOutcome start = solver.reference(x, 0.006, {.tolerance = 1e-12, .jet = 4});
    REQUIRE(start.state.jet);
    const auto error = [&](double distance, int order) {
      double square = 0;
      for (const Vec3& side : {Vec3(1, 0.4, -0.3), Vec3(-0.5, 1, 0.6), Vec3(0.2, -0.7, 1)})
        for (const double sign : {1.0, -1.0}) {
          const Vec3 d = sign * distance * side.normalized();
          const State truth = solver.from(*start.equilibrium, x + d, exact).state;
          square += (start.state.force - start.state.stiffness * d -
                     jet_terms(*start.state.jet, d, order + 1).gradient - truth.force)
                        .squaredNorm();
        }
      return std::sqrt(square);
    };
    const double h = x.norm() > 0.8 * radius ? 0.01 * radius : std::min(0.002, 0.2 * radius);
    for (int order = 1; order <= 4; ++order) {
      const double near = error(h, order), far = error(2 * h, order);
      INFO("at " << x.transpose() << ", order " << order << ": " << far << " and " << near << " N");
      CHECK(near > 1e-11);
      CHECK(std::log2(far / near) == Approx(order + 1).margin(0.2));
    }
  }
}

TEST_CASE("A lattice of a body with a fine jet is that of the body without, plus the jet") {
  const auto plain = padded_block(Law::neo_hookean), corrected = with_fine(plain);
  LatticeOptions options;
  options.spacing = 0.005;
  options.box = {Vec3(-0.01, -0.005, -0.01), Vec3(0.01, 0.005, 0.01)};
  options.threads = 2;
  const auto states_of = [&](const std::shared_ptr<Body>& body) {
    std::vector<State> states;
    CHECK(generate_lattice(body, options, [&](State s) { states.push_back(std::move(s)); }).failed == 0);
    std::ranges::sort(states, {}, [](const State& s) { return std::array{s.at[0], s.at[1], s.at[2]}; });
    return states;
  };
  const std::vector<State> without = states_of(plain), with = states_of(corrected);
  REQUIRE(without.size() == with.size());
  CHECK(with.size() == 75);
  for (std::size_t i = 0; i < with.size(); ++i) {
    REQUIRE(with[i].at == without[i].at);
    INFO("at " << with[i].at.transpose());
    const JetTerms change = corrected->fine->at(with[i].at);
    const double force = std::max(0.01, with[i].force.norm());
    CHECK((with[i].force - without[i].force + change.gradient).norm() < 3e-6 * force);
    CHECK((with[i].stiffness - without[i].stiffness - change.hessian).norm() <
          2e-4 * with[i].stiffness.norm());
    CHECK(std::abs(with[i].energy - without[i].energy - change.energy) < 1e-5 * with[i].energy + 1e-12);
  }
}

TEST_CASE("A fine jet takes at least four fifths of a coarse body's error") {
  const auto check = [](const char* phantom, std::size_t elements, double distance) {
    const auto coarse = padded_phantom(phantom, elements, phantom_tip(phantom));
    Solver truth(fine_of(*coarse)), plain(coarse), corrected(with_fine(coarse));
    for (const Vec3& way : {Vec3(0.3, 0.4, -1), Vec3(0.3, 0.8, -0.5)}) {
      const Vec3 x = distance * way.normalized();
      const State exact = truth.reference(x, distance).state;
      REQUIRE(exact.solve.status == SolveStatus::converged);
      const auto error = [&](Solver& solver) {
        return (solver.reference(x, 0.005).state.force - exact.force).norm() / exact.force.norm();
      };
      const double before = error(plain), after = error(corrected);
      CAPTURE(phantom, distance, before, after);
      CHECK(before > 0.05);
      CHECK(after < before / 5);
      CHECK(after < 0.01);
    }
  };
  check("liver", 300, 0.015);
  check("beam", 300, 0.008);
}

TEST_CASE("the error that is left is the change by refinement and the degrees that are missed, as vectors") {
  RestJet fine, finer, solved;
  fine.stiffness = 100 * Mat3::Identity(), finer.stiffness = 96 * Mat3::Identity();
  solved.stiffness = 110 * Mat3::Identity();
  fine.jet.order = finer.jet.order = solved.jet.order = most_jet_order;
  RestJet coarse = fine;
  coarse.stiffness *= 1.5;
  int made = 0;
  const FineJet jet(fine, coarse, "", [&]() -> std::optional<Refinement> {
    ++made;
    return Refinement{finer, 2, std::make_shared<const Body>(), solved};
  });
  CHECK(made == 0);
  REQUIRE(jet.solved());
  const Vec3 x(0.01, 0, 0), force = -100 * x;
  // the solved body answers as its own jet does, but for 0.03 N across: what the degrees miss
  const auto error = jet.error_left(x, force, -110 * x + Vec3(0, 0.03, 0));
  CHECK(made == 1);
  REQUIRE(error);
  const double mesh = 0.04 / (1 - std::pow(2, -3.7));  // 0.04 N of 1 N, and what further refinement adds
  CHECK(error->error == Approx(std::hypot(mesh, 0.03)).epsilon(1e-12));
  CHECK(error->low < error->error);
  CHECK(error->high > error->error);
  CHECK_FALSE(jet.error_left(Vec3::Zero(), force, force));
  CHECK_FALSE(FineJet(fine, coarse, "").solved());
}
