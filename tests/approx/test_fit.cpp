#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "approx/updater.hpp"
#include "geometry/error.hpp"
#include "tests/approx/sets.hpp"

using namespace forefeel;
using namespace forefeel::testing;

namespace {

struct Case {
  Kernel kernel;
  Data data;
};
const std::vector<Case> cases = {{Kernel::linear, Data::force},
                                 {Kernel::cubic, Data::force},
                                 {Kernel::quintic, Data::force},
                                 {Kernel::cubic, Data::force_and_stiffness},
                                 {Kernel::quintic, Data::force_and_stiffness}};

int power_of(Kernel kernel) { return kernel == Kernel::linear ? 1 : kernel == Kernel::cubic ? 3 : 5; }
int degree_of(Kernel kernel) { return kernel == Kernel::quintic ? 2 : 1; }

std::vector<Vec3> random_points(std::size_t n, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-size, size);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < n; ++i) points.emplace_back(unit(random), unit(random), unit(random));
  return points;
}

}  // namespace

TEST_CASE("A model interpolates its states and equals the saddle system solved in long double") {
  for (const auto& [kernel, data] : cases) {
    CAPTURE(name(kernel), name(data));
    const auto states = states_at(random_points(40, 0.03, 7));
    const Model model = fit(states, {.kernel = kernel, .data = data}, Vec3::Zero());
    CHECK(model.kernel() == kernel);
    const Judge judge(states, power_of(kernel), degree_of(kernel), data == Data::force_and_stiffness);
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
