// Energy jets of solved states: how their force errs, and how far they are trusted.
#include <Eigen/LU>
#include <Eigen/SVD>

#include "pad_body.hpp"
#include "region_body.hpp"
#include "solver/body/law.hpp"
#include "solver/jet/jet_maker.hpp"
#include "solver/jet/rest_jet.hpp"
#include "tests/support/test.hpp"

namespace {

const SolveOptions exact{.tolerance = 1e-12};
const SolveOptions with_jet{.tolerance = 1e-12, .jet = 4};

constexpr Law nonlinear[] = {Law::st_venant_kirchhoff, Law::neo_hookean, Law::stable_neo_hookean,
                             Law::mooney_rivlin};

// Force of order p at distance d.
Vec3 force_of(const State& state, const Vec3& d, int order) {
  return state.force - state.stiffness * d - jet_terms(*state.jet, d, order + 1).gradient;
}

using Errors = std::array<double, 5>;  // of orders 1 to 4

// Root of the sum of squares over three directions and their opposites, where odd remainders cancel [N].
Errors errors_at(Solver& solver, const SolveOutcome& start, double distance) {
  Errors squares{};
  for (const Vec3& way : {Vec3(1, 0.4, -0.3), Vec3(-0.5, 1, 0.6), Vec3(0.2, -0.7, 1)})
    for (const double sign : {1.0, -1.0}) {
      const Vec3 d = sign * distance * way.normalized();
      const State truth = solver.from(*start.equilibrium, start.state.at + d, exact).state;
      REQUIRE(truth.solve.status == SolveStatus::converged);
      for (int order = 1; order <= 4; ++order)
        squares[static_cast<std::size_t>(order)] +=
            (force_of(start.state, d, order) - truth.force).squaredNorm();
    }
  for (double& square : squares) square = std::sqrt(square);
  return squares;
}

// Checks that the error of order p falls as |d|^(p + 1) from 2 h to h [m].
void check_slopes(const std::shared_ptr<Body>& body, const Vec3& x, double h = 0.002) {
  Solver solver(body);
  const SolveOutcome start = solver.reference(x, 0.006, with_jet);
  REQUIRE(start.state.jet);
  const Errors near = errors_at(solver, start, h), far = errors_at(solver, start, 2 * h);
  for (int order = 1; order <= 4; ++order) {
    const auto p = static_cast<std::size_t>(order);
    INFO(name(body->material.law) << " " << name(body->element) << (body->pad ? ", pad" : ", rigid") << " at "
                                  << x.transpose() << ", order " << order << ": " << far[p] << " and "
                                  << near[p] << " N");
    CHECK(near[p] > 1e-11);
    CHECK(std::log2(far[p] / near[p]) == Approx(order + 1).margin(0.2));
  }
}

double largest(const EnergyJet& jet, int degree) {
  const std::size_t from = degree == 3 ? 0 : degree == 4 ? 10 : 25, to = jet_terms_of_order(degree - 1);
  double most = 0;
  for (std::size_t i = from; i < to; ++i) most = std::max(most, std::abs(jet.coefficients[i]));
  return most;
}

void check_lower_degrees(const EnergyJet& jet, const EnergyJet& whole) {
  for (int degree = 3; degree <= 5; ++degree) {
    const std::size_t from = degree == 3 ? 0 : degree == 4 ? 10 : 25, to = jet_terms_of_order(degree - 1);
    for (std::size_t i = from; i < to; ++i) {
      INFO(jet_names()[i] << " of order " << jet.order);
      if (degree <= jet.order + 1)
        CHECK(std::abs(jet.coefficients[i] - whole.coefficients[i]) < 1e-10 * largest(whole, degree));
      else
        CHECK(jet.coefficients[i] == 0);
    }
  }
}

// Least principal stretch over all linear elements.
double least_stretch(const TetMesh& mesh, const std::vector<double>& u) {
  double least = HUGE_VAL;
  for (const Tet& tet : mesh.tets) {
    Mat3 before, after;
    const auto moved = [&](NodeIndex node) {
      return Vec3(mesh.nodes[node] +
                  Eigen::Map<const Vec3>(u.data() + 3 * static_cast<std::ptrdiff_t>(node)));
    };
    for (std::size_t c = 0; c < 3; ++c) {
      before.col(static_cast<int>(c)) = mesh.nodes[tet[c + 1]] - mesh.nodes[tet[0]];
      after.col(static_cast<int>(c)) = moved(tet[c + 1]) - moved(tet[0]);
    }
    const Mat3 f = after * before.inverse();
    least = std::min(least, f.determinant() > 0 ? f.jacobiSvd().singularValues()[2] : 0.0);
  }
  return least;
}

// The least stretch at `distance` along any direction of the series and its opposite of u_0 + U d (+ V[d, d]); V from
// differences of solved displacements.
double least_stretch_at(Solver& solver, const Equilibrium& start, double distance, bool bent) {
  const double h = 0.0005;
  const auto displaced = [&](const Vec3& d) {
    return solver.from(start, start.at + d, exact).equilibrium->displacements;
  };
  double least = HUGE_VAL;
  for (std::size_t k = 0; k < limit_direction_count; ++k) {
    const Vec3 way = Vec3(limit_directions().data() + 3 * k).normalized();
    std::vector<double> bend(start.displacements.size(), 0.0);
    if (bent) {
      const std::vector<double> up = displaced(h * way), down = displaced(-h * way);
      for (std::size_t i = 0; i < bend.size(); ++i)
        bend[i] = (up[i] + down[i] - 2 * start.displacements[i]) / (2 * h * h);
    }
    for (const double t : {distance, -distance}) {
      std::vector<double> u = start.displacements;
      for (std::size_t i = 0; i < u.size(); ++i)
        u[i] += t * Eigen::Map<const Vec3>(start.tangent.data() + 3 * i).dot(way) + t * t * bend[i];
      least = std::min(least, least_stretch(solver.body().mesh, u));
    }
  }
  return least;
}

}  // namespace

TEST_CASE("The force of order p errs as |d|^(p + 1)") {
  for (const Law law : nonlinear)
    for (const Element element : {Element::linear, Element::quadratic})
      for (const bool padded : {true, false})
        for (const Vec3& x : {Vec3(0, 0, 0), Vec3(-0.004, 0.003, 0.005)})
          // St. Venant-Kirchhoff's series reaches less far: its terms rise from 2 mm on
          check_slopes(padded ? padded_block(law, element) : block_body(law, 0.4, 1, element), x,
                       law == Law::st_venant_kirchhoff && !padded ? 0.0005 : 0.002);
}

TEST_CASE("The force of order p errs as |d|^(p + 1) on phantoms and on bodies of several laws") {
  check_slopes(padded_phantom("liver", 600, phantom_tip("liver")), Vec3::Zero());
  check_slopes(gripped_phantom("liver", 600), Vec3(0.003, -0.002, -0.008));
  check_slopes(padded_phantom("beam", 300, phantom_tip("beam"), Law::mooney_rivlin), Vec3(0, 0.002, -0.004));
  const Material end{Law::mooney_rivlin, 9000, 0.3};
  for (const Element element : {Element::linear, Element::quadratic}) {
    auto body =
        region_body({Law::neo_hookean, 5000, 0.4}, {Law::st_venant_kirchhoff, 20000, 0.3}, &end, 1, element);
    check_slopes(body, Vec3(-0.003, 0.004, 0.002));
    body->contact.clear();
    body->pad = padded_block(Law::neo_hookean)->pad;
    check_slopes(body, Vec3::Zero());
  }
}

TEST_CASE("A jet of a lower order is the lower degrees of a higher one") {
  for (const Law law : nonlinear)
    for (const Element element : {Element::linear, Element::quadratic})
      for (const bool padded : {true, false})
        for (const Vec3& x : {Vec3(0, 0, 0), Vec3(-0.004, 0.003, 0.005)}) {
          INFO(name(law) << " " << name(element) << (padded ? ", pad" : ", rigid"));
          Solver solver(padded ? padded_block(law, element) : block_body(law, 0.4, 1, element));
          const EnergyJet whole = *solver.reference(x, 0.006, with_jet).state.jet;
          CHECK(whole.order == 4);
          for (const int order : {2, 3})
            check_lower_degrees(*solver.reference(x, 0.006, {.tolerance = 1e-12, .jet = order}).state.jet,
                                whole);
          CHECK_FALSE(solver.reference(x, 0.006, exact).state.jet);
        }
}

TEST_CASE("The jet of a linear body has no terms beyond its stiffness") {
  for (const Element element : {Element::linear, Element::quadratic})
    for (const bool padded : {true, false}) {
      const auto body =
          padded ? padded_block(Law::linear, element) : block_body(Law::linear, 0.4, 1, element);
      const RestJet rest = rest_jet(*body, {});
      Solver solver(body);
      const State state = solver.reference(Vec3(0.01, 0.02, -0.03), 0.006, with_jet).state;
      CHECK((rest.stiffness - state.stiffness).norm() < 1e-12 * rest.stiffness.norm());
      REQUIRE(state.jet);
      for (const EnergyJet& jet : {rest.jet, *state.jet})
        for (int degree = 3; degree <= 5; ++degree)  // at 1 cm
          CHECK(largest(jet, degree) * std::pow(0.01, degree - 2) < 1e-10 * rest.stiffness.norm());
    }
}

TEST_CASE("A state solved beside others has the jet of a state solved alone") {
  for (const Law law : {Law::neo_hookean, Law::st_venant_kirchhoff}) {
    const auto body = padded_block(law);
    Solver solver(body);
    const SolveOutcome start = solver.reference(Vec3(0.002, 0, -0.004), 0.006, exact);
    const std::vector<Vec3> xs{Vec3(0.003, 0.001, -0.005), Vec3(0.001, -0.002, -0.006), Vec3(0, 0, -0.004)};
    const auto outcomes = solver.beside(*start.equilibrium, xs, {.tolerance = 1e-6, .jet = 4});
    for (std::size_t i = 0; i < xs.size(); ++i) {
      REQUIRE(outcomes[i].state.jet);
      const EnergyJet alone = *solver.reference(xs[i], 0.006, with_jet).state.jet;
      for (std::size_t k = 0; k < jet_size; ++k)
        CHECK(std::abs(outcomes[i].state.jet->coefficients[k] - alone.coefficients[k]) <
              1e-7 * largest(alone, k < 10   ? 3
                                    : k < 25 ? 4
                                             : 5));
      CHECK(outcomes[i].state.jet->limit == Approx(alone.limit).epsilon(1e-3));
    }
  }
}

TEST_CASE("The jet at rest is that of the state at rest") {
  for (const Element element : {Element::linear, Element::quadratic}) {
    const auto body = padded_block(Law::neo_hookean, element);
    const RestJet rest = rest_jet(*body, {});
    const State state = Solver(body).reference(Vec3::Zero(), 0.006, with_jet).state;
    CHECK((rest.stiffness - state.stiffness).norm() < 1e-12 * state.stiffness.norm());
    check_lower_degrees(rest.jet, *state.jet);
  }
}

TEST_CASE("At the material limit the jet's own displacement reaches the law's least stretch") {
  for (const Law law : nonlinear)
    for (const bool padded : {true, false})
      for (const Vec3& x : {Vec3(0, 0, 0), Vec3(-0.004, 0.003, 0.005)})
        for (const int order : {2, 4}) {
          Solver solver(padded ? padded_block(law) : block_body(law));
          const SolveOutcome start = solver.reference(x, 0.006, {.tolerance = 1e-12, .jet = order});
          const double limit = start.state.jet->limit, least = law_entry(law).least_stretch;
          INFO(name(law) << (padded ? ", pad" : ", rigid") << ", order " << order << " at " << x.transpose()
                         << ": limit " << limit);
          CHECK(std::isfinite(limit) == (least > 0));
          if (!std::isfinite(limit)) continue;
          CHECK(limit > 0.001);
          CHECK(least_stretch_at(solver, *start.equilibrium, limit, order > 2) ==
                Approx(least).epsilon(0.01));
          CHECK(least_stretch_at(solver, *start.equilibrium, 0.9 * limit, order > 2) > least);
        }
  CHECK(
      std::isinf(Solver(block_body(Law::linear)).reference(Vec3::Zero(), 0.006, with_jet).state.jet->limit));
  CHECK(law_entry(Law::st_venant_kirchhoff).least_stretch == Approx(1 / std::sqrt(3.0)));
}
