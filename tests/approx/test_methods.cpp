#include "approx/methods/older_methods.hpp"
#include "approx/methods/rbf_network.hpp"
#include "tests/approx/sets.hpp"
#include "tests/support/test.hpp"

namespace {

double worst(const Approximation& field, const std::vector<Vec3>& points, const auto& exact) {
  double error = 0;
  for (const Vec3& x : points) error = std::max(error, (field.force(x) - exact(x)).norm());
  return error;
}

}  // namespace

TEST_CASE("Lattice methods are exact on the polynomials they hold and converge at their order") {
  const double h = 0.006;
  const auto with = [&](const auto& f, double spacing, int half) {
    auto states = states_at(lattice_points(half, spacing));
    for (auto& s : states) s.force = f(s.at);
    return states;
  };
  const auto multilinear = [](const Vec3& x) {
    return Vec3(1 + x[0] * x[1], x[1] * x[2] - 2 * x[0], x[0] * x[1] * x[2]);
  };
  const auto quadratic = [](const Vec3& x) {
    return Vec3(x[0] * x[0], x[1] * x[1] - x[2], x[2] * x[2] + x[0] * x[1]);
  };
  CHECK(worst({Method::trilinear, with(multilinear, h, 4), {.spacing = h}}, random_points(100, 0.0239, 1),
              multilinear) < 1e-15);
  CHECK(worst({Method::tricubic, with(quadratic, h, 4), {.spacing = h}}, random_points(100, 0.0239, 2),
              quadratic) < 1e-15);
  const auto field = [](const Vec3& x) { return field_state(x).force; };
  const auto error = [&](Method method, double spacing, int half) {
    return worst({method, with(field, spacing, half), {.spacing = spacing}}, random_points(200, 0.02, 3),
                 field);
  };
  CHECK(error(Method::trilinear, h, 4) / error(Method::trilinear, h / 2, 8) > 3.3);
  CHECK(error(Method::tricubic, h, 4) / error(Method::tricubic, h / 2, 8) > 6);
  CHECK(error(Method::tricubic, h, 4) < 0.2 * error(Method::trilinear, h, 4));
  // Positions on nodes and faces, including the last ones. Outside, the value is that of the nearest place of the
  // lattice.
  const auto states = with(field, h, 2);
  for (const Method method : {Method::trilinear, Method::tricubic}) {
    const Approximation lattice(method, states, {.spacing = h});
    for (const auto& s : states) CHECK((lattice.force(s.at) - s.force).norm() < 1e-12);
    CHECK((lattice.force(Vec3(1, 0, 0)) - field(Vec3(2 * h, 0, 0))).norm() < 1e-12);
    for (const Vec3& x : random_points(200, 6 * h, 4)) {
      const Vec3 drawn = x.cwiseMax(Vec3::Constant(-2 * h)).cwiseMin(Vec3::Constant(2 * h));
      CHECK((lattice.force(x) - lattice.force((1 - 1e-9) * drawn)).norm() < 1e-6);
    }
  }
  CHECK_THROWS_AS(Approximation(Method::trilinear, states_at(random_points(30, 0.02, 4)), {.spacing = h}),
                  InputError);
}

TEST_CASE("Deflection curves are exact for a linear body and linear in depth") {
  const Mat3 k = field_state(Vec3::Zero()).stiffness;
  auto states = states_at(lattice_points(3, 0.006));
  for (auto& s : states) s.force = -k * s.at;
  const Approximation curves(Method::deflection, states, {});
  // Exact where three directions are distinguished; close to exact everywhere.
  std::size_t exact = 0;
  for (const Vec3& x : random_points(200, 0.017, 5)) {
    const double error = (curves.force(x) + k * x).norm();
    exact += error < 1e-10 ? 1 : 0;
    CHECK(error < 0.5 * (k * x).norm());
  }
  CHECK(exact > 120);
  CHECK(curves.force(Vec3::Zero()).norm() == 0);
}

TEST_CASE("A deflection curve goes through its states, is straight between them and goes on beyond") {
  const auto stiffening = [](double d) { return -(40 * d + 1e5 * d * d * d); };
  std::vector<State> states;
  for (int axis = 0; axis < 3; ++axis)
    for (const double depth : {0.01, 0.02, 0.03}) {
      State s = field_state(depth * Vec3::Unit(axis));
      s.force = stiffening(depth) * Vec3::Unit(axis);
      states.push_back(s);
    }
  const Approximation curves(Method::deflection, states, {});
  const auto along = [&](double d) { return curves.force(Vec3(0, d, 0))[1]; };
  for (const double d : {0.01, 0.02, 0.03}) CHECK(along(d) == Approx(stiffening(d)).epsilon(1e-12));
  CHECK(along(0.004) == Approx(0.4 * stiffening(0.01)).epsilon(1e-12));
  CHECK(along(0.0125) == Approx(0.75 * stiffening(0.01) + 0.25 * stiffening(0.02)).epsilon(1e-12));
  CHECK(along(0.04) == Approx(2 * stiffening(0.03) - stiffening(0.02)).epsilon(1e-12));
  // Between directions: the forces at the depth of x, weighted by the share of each direction.
  const Vec3 x = 0.02 * Vec3(1, 2, 2) / 3;
  CHECK((curves.force(x) - stiffening(0.02) * Vec3(1, 2, 2) / 3).norm() < 1e-12);
  CHECK((curves.force(Vec3(0, -0.01, 0)) + curves.force(Vec3(0, 0.01, 0))).norm() < 1e-12);
}

// Least squares: the residual is orthogonal to the function of every centre and to the polynomial.
TEST_CASE("A network with fewer centres than states leaves what no change of its weights can mend") {
  const auto states = states_at(random_points(120, 0.03, 9));
  const Approximation network(Method::rbf_network, states, {.centres = 25});
  const RbfNetwork same(states, 25);
  CHECK(same.centres() == 25);
  double left = 0, across[4] = {};
  for (const auto& s : states) {
    const double rest = (s.force - network.force(s.at))[0];
    left += std::abs(rest);
    across[0] += rest;
    for (int d = 0; d < 3; ++d) across[1 + d] += rest * s.at[d] / 0.03;
  }
  CHECK(left > 1e-3);
  for (const double sum : across) CHECK(std::abs(sum) < 1e-9 * left);
}

TEST_CASE("Two forces extrapolate along their line") {
  std::vector<State> states(2);
  states[0].at = Vec3(0.01, 0, 0);
  states[0].force = Vec3(-1, 0.5, 0);
  states[1].at = Vec3(0.02, 0, 0);
  states[1].force = Vec3(-3, 1.5, 0);
  const Approximation line(Method::two_force, states, {});
  CHECK((line.force(Vec3(0.03, 0, 0)) - Vec3(-5, 2.5, 0)).norm() < 1e-12);
  CHECK((line.force(Vec3(0.025, 0.02, 0)) - Vec3(-4, 2, 0)).norm() < 1e-12);
}

TEST_CASE("Offline RBF interpolates; a network with all centres does too, with fewer it is near") {
  const auto states = states_at(lattice_points(2, 0.01));
  const auto field = [](const Vec3& x) { return field_state(x).force; };
  const Approximation offline(Method::offline_rbf, states, {.model = {.kernel = Kernel::cubic}});
  const Approximation all(Method::rbf_network, states, {.centres = states.size()});
  const Approximation fewer(Method::rbf_network, states, {.centres = 40});
  double largest = 0;
  for (const auto& s : states) {
    largest = std::max(largest, s.force.norm());
    CHECK((offline.force(s.at) - s.force).norm() < 1e-10);
    CHECK((all.force(s.at) - s.force).norm() < 1e-8);
  }
  CHECK(worst(fewer, random_points(100, 0.015, 6), field) < 0.05 * largest);
}

// On a lattice nearly all distances are shared by several states, so that every choice of a centre is a tie.
TEST_CASE("A network does not depend on the order of states, the unit of length or the origin") {
  const auto at = random_points(50, 0.02, 12);
  std::mt19937 random(5);
  for (const bool flat : {false, true})
    for (const std::size_t centres : {std::size_t{0}, std::size_t{40}, std::size_t{1000}}) {
      auto states = states_at(lattice_points(2, 0.01));
      if (flat) std::erase_if(states, [](const State& s) { return std::abs(s.at[0] - s.at[1]) > 1e-6; });
      const RbfNetwork plain(states, centres);
      double largest = 0;
      for (const Vec3& x : at) largest = std::max(largest, plain.force(x).norm());
      REQUIRE(largest > 0.01);
      const auto apart = [&](double unit, const Vec3& offset) {
        auto others = states;
        std::ranges::shuffle(others, random);
        for (auto& s : others) s.at = unit * s.at + offset;
        const RbfNetwork other(others, centres);
        CHECK(other.centres() == plain.centres());
        double most = 0;
        for (const Vec3& x : at)
          most = std::max(most, (other.force(unit * x + offset) - plain.force(x)).norm());
        return most / largest;
      };
      CAPTURE(flat, centres);
      for (int repeat = 0; repeat < 5; ++repeat) CHECK(apart(1, Vec3::Zero()) < 1e-8);
      CHECK(apart(1e3, Vec3::Zero()) < 1e-8);
      CHECK(apart(0.37, Vec3::Zero()) < 1e-8);
      CHECK(apart(1, Vec3(1000, -1000, 1000)) < 1e-8);
      CHECK(apart(1e3, Vec3(1e6, 1e6, 1e6)) < 1e-8);
    }
}

// |f| <= max |F_i| + 2 S d, with S recomputed here over all pairs, which can only make it larger.
TEST_CASE("No older method passes its bound, however far out and however few states it has") {
  std::vector<std::vector<State>> sets = {states_at(lattice_points(1, 0.01)),
                                          states_at(random_points(40, 0.02, 3))};
  for (const std::size_t few : {1u, 2u, 3u, 4u}) {
    const auto& all = sets[1];
    sets.emplace_back(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(few));
  }
  bool reached = false;
  for (const auto& states : sets)
    for (const Method method :
         {Method::deflection, Method::two_force, Method::rbf_network, Method::trilinear}) {
      if (method == Method::trilinear && &states != &sets[0]) continue;
      const Approximation field(method, states, {.spacing = 0.01});
      double largest = 0, steepest = 0;
      for (const State& a : states) {
        largest = std::max(largest, a.force.norm());
        steepest = std::max(steepest, a.stiffness.norm());
        for (const State& b : states)
          if (a.at != b.at) steepest = std::max(steepest, (a.force - b.force).norm() / (a.at - b.at).norm());
      }
      for (const double size : {0.02, 0.14, 3.0, 1e6})
        for (const Vec3& x : random_points(60, size, 8)) {
          double nearest = 1e300;
          for (const State& s : states) nearest = std::min(nearest, (s.at - x).norm());
          const Vec3 force = field.force(x);
          REQUIRE(force.allFinite());
          CHECK(force.norm() <= (1 + 1e-12) * (largest + 2 * steepest * nearest));
          CHECK(force.norm() <= (1 + 1e-12) * std::max(field.at({x}).reach.bound, largest));
          reached = reached || std::abs(force.norm() / field.at({x}).reach.bound - 1) < 1e-9;
        }
      const Vec3 far(0.3, 0.2, -0.5);  // gradually
      CHECK((field.force(far) - field.force(far + Vec3(1e-9, 0, 0))).norm() < 1e-5);
    }
  CHECK(reached);
}
