// Energy around closed loops, and the power function, where they are known exactly.

#include <Eigen/Eigenvalues>

#include "approx/error/leave_one_out.hpp"
#include "tests/approx/loop_energy.hpp"
#include "tests/approx/sets.hpp"
#include "tests/support/test.hpp"

namespace {

std::vector<State> linear_states(const Mat3& k) {
  std::vector<State> states;
  for (const Vec3& x : lattice_points(2, 0.006)) {
    State s;
    s.at = x;
    s.force = -k * x;
    s.stiffness = k;
    s.solve.status = SolveStatus::converged;
    states.push_back(s);
  }
  return states;
}

}  // namespace

TEST_CASE("A linear body gives nothing away around a loop, whatever the method and the set") {
  Mat3 k;
  k << 80, 10, -5, 10, 120, 8, -5, 8, 60;
  const auto states = linear_states(k);
  StateSpace space({.spacing = 0.006});
  for (const State& s : states) space.insert(s);
  const auto loop = ellipse(Vec3(0.001, -0.002, 0.0005), Vec3(0.007, 0, 0.002), Vec3(0, 0.006, 0.003), 400);
  CHECK(loop_energy(loop, [&](const Vec3& x) { return Vec3(-k * x); }).ratio() < 1e-15);
  for (const Kernel kernel : {Kernel::linear, Kernel::cubic, Kernel::quintic})
    for (const Data data : {Data::force, Data::force_and_stiffness}) {
      if (kernel == Kernel::linear && data == Data::force_and_stiffness) continue;
      CAPTURE(name(kernel), name(data));
      const ModelOptions options{.kernel = kernel, .data = data, .neighbours = 25};
      const Model fixed = fit_model(states, options, Vec3::Zero());
      CHECK(loop_energy(loop, [&](const Vec3& x) { return fixed.force(x); }).ratio() < 1e-11);
      ModelUpdater updater(space, options);
      CHECK(loop_energy(loop, [&](const Vec3& x) { return updater.model_at(x).force(x); }).ratio() < 1e-9);
    }
}

TEST_CASE("A field that turns does the work of its circulation") {
  const double radius = 0.02, rate = 3;
  const std::size_t points = 5000;
  const auto loop = ellipse(Vec3(0.1, 0.2, 0.3), radius * Vec3::UnitX(), radius * Vec3::UnitY(), points);
  const LoopEnergy energy =
      loop_energy(loop, [&](const Vec3& x) { return Vec3(rate * Vec3::UnitZ().cross(x)); });
  // A polygon of m corners in a circle has area m/2 r^2 sin(2 pi / m); the circulation is 2 rate times it.
  CHECK(energy.net == Approx(rate * points * radius * radius * std::sin(2 * M_PI / points)).epsilon(1e-12));
  CHECK(energy.gross >= energy.net);
  CHECK(loop_energy({Vec3::Zero()}, [](const Vec3& x) { return x; }).gross == 0);
}

TEST_CASE("The quadrature of a smooth conservative field vanishes with the points") {
  // Around rest the field would be odd and cancel by symmetry.
  const auto field = [](const Vec3& x) { return field_state(x).force; };
  double before = 1;
  for (const std::size_t points : {6, 12, 24}) {
    const double ratio =
        loop_energy(ellipse(Vec3(0.01, 0.004, -0.006), Vec3(0.02, 0, 0), Vec3(0, 0.012, 0.01), points), field)
            .ratio();
    CHECK(ratio < before);
    before = ratio;
  }
  CHECK(before < 1e-6);
}

TEST_CASE("The power function is the worst error over fields of unit norm") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-0.01, 0.01);
  std::vector<Vec3> points;
  for (int i = 0; i < 18; ++i) points.emplace_back(unit(random), unit(random), unit(random));
  const auto states = states_at(points);
  const Vec3 x(0.003, -0.002, 0.004);
  for (const auto& [kernel, power, sign] :
       {std::tuple{Kernel::linear, 1, -1.0}, std::tuple{Kernel::cubic, 3, 1.0},
        std::tuple{Kernel::quintic, 5, -1.0}}) {
    CAPTURE(name(kernel));
    const ModelOptions options{.kernel = kernel, .data = Data::force};
    const double p = power_function(states, options, x);
    // P^2 is the squared norm of the functional f(x) - sum u_i f(x_i), computed here by definition in long double.
    const auto n = static_cast<Eigen::Index>(points.size());
    const int terms = power == 5 ? 10 : 4;
    RealMatrix system = RealMatrix::Zero(n + terms, n + terms), right = RealMatrix::Zero(n + terms, 1);
    const auto monomial = [](int t, const Vec3& y) {
      const Real a = y[0] / 0.01L, b = y[1] / 0.01L, c = y[2] / 0.01L;
      const Real all[] = {1, a, b, c, a * a, b * b, c * c, a * b, a * c, b * c};
      return all[t];
    };
    const auto phi = [power = power](const Vec3& a, const Vec3& b) {
      return std::pow(Real((a - b).norm()), Real(power));
    };
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) system(i, j) = phi(points[std::size_t(i)], points[std::size_t(j)]);
      for (int t = 0; t < terms; ++t)
        system(i, n + t) = system(n + t, i) = monomial(t, points[std::size_t(i)]);
      right(i, 0) = phi(points[std::size_t(i)], x);
    }
    for (int t = 0; t < terms; ++t) right(n + t, 0) = monomial(t, x);
    // In units of 1 cm the system is well scaled.
    system.topLeftCorner(n, n) *= std::pow(100.0L, Real(power));
    right.topRows(n) *= std::pow(100.0L, Real(power));
    const RealMatrix u = system.fullPivLu().solve(right).topRows(n);
    Real squared = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      squared -= 2 * u(i, 0) * phi(points[std::size_t(i)], x);
      for (Eigen::Index j = 0; j < n; ++j)
        squared += u(i, 0) * u(j, 0) * phi(points[std::size_t(i)], points[std::size_t(j)]);
    }
    REQUIRE(Real(sign) * squared > 0);
    CHECK(p == Approx(double(std::sqrt(Real(sign) * squared))).epsilon(1e-6));
  }
}

TEST_CASE("The power function is zero at states, grows away from them and shrinks with more data") {
  const auto states = states_at(lattice_points(1, 0.006));
  for (const Kernel kernel : {Kernel::cubic, Kernel::quintic})
    for (const Data data : {Data::force, Data::force_and_stiffness}) {
      CAPTURE(name(kernel), name(data));
      const ModelOptions options{.kernel = kernel, .data = data};
      const double middle = power_function(states, options, Vec3::Constant(0.003)),
                   outside = power_function(states, options, Vec3(0.012, 0.003, 0.003)),
                   far = power_function(states, options, Vec3(0.024, 0.003, 0.003));
      CHECK(power_function(states, options, states[5].at) < 1e-3 * middle);
      CHECK(middle < outside);
      CHECK(outside < far);
      if (data == Data::force_and_stiffness)
        CHECK(middle <
              power_function(states, {.kernel = kernel, .data = Data::force}, Vec3::Constant(0.003)));
    }
  const auto flat = states_at(
      {Vec3(0, 0, 0), Vec3(0.006, 0, 0), Vec3(0, 0.006, 0), Vec3(0.006, 0.006, 0), Vec3(0.012, 0, 0)});
  CHECK(std::isinf(power_function(flat, {.kernel = Kernel::cubic, .data = Data::force}, Vec3(0, 0, 0.003))));
}
