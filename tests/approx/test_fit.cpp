#include "approx/model/updater.hpp"
#include "tests/approx/sets.hpp"
#include "tests/support/test.hpp"

namespace {

int kernel_power(Kernel kernel) {
  return kernel == Kernel::linear ? 1 : kernel == Kernel::cubic ? 3 : 5;
}
int degree_of(Kernel kernel) {
  return kernel == Kernel::quintic ? 2 : 1;
}

}  // namespace

TEST_CASE("A model interpolates its states and equals the saddle system solved in long double") {
  for (const auto& [kernel, data] : fit_cases) {
    CAPTURE(name(kernel), name(data));
    const auto states = states_at(random_points(40, 0.03, 7));
    const Model model = fit_model(states, {.kernel = kernel, .data = data}, Vec3::Zero());
    CHECK(model.kernel() == kernel);
    const Judge judge(states, kernel_power(kernel), degree_of(kernel), data == Data::force_and_stiffness);
    for (const auto& s : states) CHECK((model.force(s.at) - s.force).norm() < 1e-10 * 3);
    for (const auto& x : random_points(50, 0.028, 8)) CHECK((model.force(x) - judge.force(x)).norm() < 1e-9);
    if (data == Data::force_and_stiffness)
      for (const auto& s : states) {
        Vec3 f;
        Mat3 j;
        model.evaluate(s.at, f, j);
        CHECK((j + s.stiffness).norm() < 1e-8 * s.stiffness.norm());
      }
  }
}

TEST_CASE("The Jacobian is the derivative of the force, inside, between and far outside") {
  for (const auto& [kernel, data] : fit_cases) {
    CAPTURE(name(kernel), name(data));
    const auto states = states_at(random_points(40, 0.03, 7));
    const Model model = fit_model(states, {.kernel = kernel, .data = data}, Vec3(0.01, 0, 0));
    std::mt19937 random(4);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int q = 0; q < 200; ++q) {
      const double reach = q % 4 == 0 ? 0.03 : q % 4 == 1 ? 0.08 : q % 4 == 2 ? 0.15 : 0.5;
      const Vec3 x = reach * Vec3(unit(random), unit(random), unit(random));
      Vec3 f;
      Mat3 j, differences;
      model.evaluate(x, f, j);
      CHECK((f - model.force(x)).norm() <= 1e-12 * (1 + f.norm()));
      const double step = 1e-5;
      for (int d = 0; d < 3; ++d) {
        const Vec3 e = step * Vec3::Unit(d);
        differences.col(d) = (8 * (model.force(x + e) - model.force(x - e)) -
                              (model.force(x + 2 * e) - model.force(x - 2 * e))) /
                             (12 * step);
      }
      double nearest = 1;
      for (const auto& s : states) nearest = std::min(nearest, (s.at - x).norm());
      if (nearest < 3e-3) continue;  // r has a kink there
      CHECK((j - differences).norm() < 2e-4 * (1 + j.norm()));
    }
  }
}

TEST_CASE("Kernel and degree step down by rank") {
  const double h = 0.006;
  std::vector<Vec3> line, plane, two_planes;
  for (int i = 0; i < 5; ++i) {
    line.emplace_back(i * h, 2 * i * h, -i * h);
    for (int j = 0; j < 5; ++j) {
      plane.emplace_back(i * h, j * h, 0.3 * i * h - 0.7 * j * h);  // oblique
      for (int k = 0; k < 2; ++k) two_planes.emplace_back(k * h, i * h, j * h);
    }
  }
  const auto model = [&](const std::vector<Vec3>& points, Kernel kernel, Data data) {
    return fit_model(states_at(points), {.kernel = kernel, .data = data}, points.front());
  };
  CHECK(model(two_planes, Kernel::quintic, Data::force).kernel() == Kernel::cubic);
  CHECK(model(two_planes, Kernel::cubic, Data::force).kernel() == Kernel::cubic);
  CHECK(model(plane, Kernel::quintic, Data::force).kernel() == Kernel::linear);
  CHECK(model(plane, Kernel::cubic, Data::force).kernel() == Kernel::linear);
  CHECK(model(line, Kernel::linear, Data::force).kernel() == Kernel::linear);
  CHECK(model(plane, Kernel::quintic, Data::force_and_stiffness).kernel() == Kernel::cubic);
  CHECK(model(two_planes, Kernel::quintic, Data::force_and_stiffness).kernel() == Kernel::quintic);
  for (const auto& [kernel, data] : fit_cases)
    for (const auto* set : {&line, &plane, &two_planes}) {
      CAPTURE(name(kernel), name(data), set->size());
      const Model m = model(*set, kernel, data);
      CHECK_FALSE(m.is_tangent());
      for (const Vec3& x : *set) CHECK((m.force(x) - field_state(x).force).norm() < 1e-9);
    }
}

// On the plane or line of the set: the interpolant of the level that the set determines, by an LU with
// complete pivoting in long double. Away from it: a force within the bound.
TEST_CASE("Exactly coplanar and collinear sets give the interpolant of their level") {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> unit(-0.03, 0.03);
  const auto on_plane = [&] {
    const double a = unit(random), b = unit(random);
    return Vec3(a, b, 0.25 * a - 0.5 * b);  // exact in binary
  };
  const auto on_line = [&] {
    const double a = unit(random);
    return Vec3(a, 0.5 * a, -0.25 * a);
  };
  for (const bool plane : {true, false}) {
    std::vector<Vec3> points;
    for (int i = 0; i < 30; ++i) points.push_back(plane ? on_plane() : on_line());
    const auto states = states_at(points);
    for (const auto& [kernel, data] : fit_cases) {
      CAPTURE(plane, name(kernel), name(data));
      const Model model = fit_model(states, {.kernel = kernel, .data = data}, Vec3::Zero());
      const Judge judge(states, power_of(model), model.degree(), model.uses_stiffness());
      for (int q = 0; q < 50; ++q) {
        const Vec3 x = plane ? on_plane() : on_line();
        CHECK((model.force(x) - judge.force(x)).norm() < 1e-9);
        const Vec3 beside = model.force(x + Vec3(0, 0, 0.01));
        CHECK(beside.norm() <= model.force_bound());
      }
    }
  }
}

TEST_CASE("One state, duplicates of one, and no state") {
  const State state = field_state({0.01, -0.004, 0.007});
  for (const auto& [kernel, data] : fit_cases)
    for (const std::size_t copies : {1, 2, 5}) {
      CAPTURE(name(kernel), name(data), copies);
      const std::vector<State> states(copies, state);
      const Model model = fit_model(states, {.kernel = kernel, .data = data}, state.at);
      CHECK(model.is_tangent());
      const Vec3 step(5e-4, -3e-4, 2e-4);
      CHECK((model.force(state.at) - state.force).norm() < 1e-12);
      CHECK((model.force(state.at + step) - (state.force - state.stiffness * step)).norm() < 1e-10);
      for (double far : {0.1, 10.0, 1e6, 1e150}) {
        const Vec3 f = model.force(Vec3(far, -far, far));
        CHECK(f.allFinite());
        CHECK(f.norm() <= model.force_bound());
      }
    }
  // Duplicates among others change nothing.
  auto states = states_at(random_points(30, 0.03, 1));
  for (const auto& [kernel, data] : fit_cases) {
    auto doubled = states;
    doubled.push_back(states[3]);
    doubled.push_back(states[17]);
    const Model one = fit_model(states, {.kernel = kernel, .data = data}, Vec3::Zero());
    const Model two = fit_model(doubled, {.kernel = kernel, .data = data}, Vec3::Zero());
    for (const Vec3& x : random_points(20, 0.02, 2)) CHECK((one.force(x) - two.force(x)).norm() < 1e-10);
  }
  const Model none;
  CHECK(none.force(Vec3(1, 2, 3)).norm() == 0);
  CHECK(none.serial() == 0);
  CHECK(fit_model({}, {}, Vec3::Zero()).force(Vec3::Zero()).norm() == 0);
}

TEST_CASE("Offsets of a kilometre and other units change nothing beyond rounding") {
  const auto points = random_points(40, 0.03, 21);
  const auto states = states_at(points);
  for (const auto& [kernel, data] : fit_cases) {
    CAPTURE(name(kernel), name(data));
    const ModelOptions options{.kernel = kernel, .data = data};
    const Model model = fit_model(states, options, Vec3::Zero());
    for (const double unit : {1e3, 1e6, 1e-3}) {  // lengths in mm, um, km
      auto scaled = states;
      for (auto& s : scaled) {
        s.at *= unit;
        s.stiffness /= unit;
      }
      const Model other = fit_model(scaled, options, Vec3::Zero());
      for (const Vec3& x : random_points(20, 0.1, 3)) {
        const Vec3 f = model.force(x);
        CHECK((other.force(unit * x) - f).norm() < 1e-9 * (1 + f.norm()));
      }
    }
    auto moved = states;
    const Vec3 offset(1000, -1000, 1000);
    for (auto& s : moved) s.at += offset;
    const Model other = fit_model(moved, options, offset);
    for (const Vec3& x : random_points(20, 0.03, 3)) {
      const Vec3 at = x + offset;
      // The coordinates themselves are rounded to 1e-13 m, which a stiffness of 100 N/m makes 1e-11 N.
      CHECK((other.force(at) - model.force(at - offset)).norm() < 1e-8);
    }
  }
}

TEST_CASE("Beyond a flat front: finite, continuous, never above the bound") {
  const double h = 0.006;
  std::vector<Vec3> all;
  for (int i = -6; i <= -2; ++i)
    for (int j = -6; j <= 6; ++j)
      for (int k = -6; k <= 6; ++k) all.emplace_back(i * h, j * h, k * h);
  const double front = -2 * h;
  for (const auto& [kernel, data] : fit_cases)
    for (const std::size_t n : {4, 9, 25, 50, 100, 300})
      for (const double out : {0.006, 0.012, 0.018, 0.024, 0.06, 0.12}) {
        if (data == Data::force_and_stiffness && n > 100 && out != 0.024) continue;  // slow
        CAPTURE(name(kernel), name(data), n, out);
        const Vec3 hip(front + out, 0.3 * h, -0.4 * h);
        auto points = all;
        std::ranges::stable_sort(points, {}, [&](const Vec3& p) { return (p - hip).norm(); });
        points.resize(n);
        const auto states = states_at(points);
        const Model model = fit_model(states, {.kernel = kernel, .data = data}, hip);
        double force = 0, stiffness = 0;
        for (const auto& s : states) {
          force = std::max(force, s.force.norm());
          stiffness = std::max(stiffness, s.stiffness.norm());
        }
        CHECK(model.force_bound() <= 1.25 * (force + stiffness * model.hold_distance()) * (1 + 1e-12));
        Vec3 before = model.force(hip);
        for (double x = hip[0]; x < hip[0] + 0.4; x += 0.001) {
          const Vec3 f = model.force(Vec3(x, hip[1], hip[2]));
          CHECK(f.allFinite());
          CHECK(f.norm() <= model.force_bound());
          CHECK((f - before).norm() < 0.2 * model.force_bound());
          before = f;
        }
        const Vec3 exact = field_state(hip).force;
        if (n >= 25 && out <= 0.012) CHECK((model.force(hip) - exact).norm() < 0.3 * force);
      }
}

TEST_CASE("A ridge smooths noise and zero ridge interpolates") {
  auto states = states_at(random_points(80, 0.03, 31));
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.02);
  auto noisy = states;
  for (auto& s : noisy) s.force += Vec3(noise(random), noise(random), noise(random));
  const auto error = [&](double ridge) {
    const Model model = fit_model(noisy, {.kernel = Kernel::cubic, .ridge = ridge}, Vec3::Zero());
    double sum = 0;
    for (const Vec3& x : random_points(100, 0.02, 5))
      sum += (model.force(x) - field_state(x).force).squaredNorm();
    return std::sqrt(sum / 100);
  };
  CHECK(error(0.01) < error(0));
  CHECK_THROWS_AS(
      fit_model(states, {.kernel = Kernel::linear, .data = Data::force_and_stiffness}, Vec3::Zero()),
      InputError);
  CHECK_THROWS_AS(fit_model(states, {.ridge = -1}, Vec3::Zero()), InputError);
}
