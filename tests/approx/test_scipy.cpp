// Comparison with an independent implementation: scipy.interpolate.RBFInterpolator.

#include <unistd.h>

#include <iomanip>

#include "approx/model/updater.hpp"
#include "geometry/meshing/phantom.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/lattice/generate.hpp"
#include "tests/approx/sets.hpp"
#include "tests/support/test.hpp"

namespace {

std::vector<Vec3> scipy_forces(const std::vector<State>& states, const std::vector<Vec3>& points,
                               Kernel kernel, std::size_t n) {
  const TemporaryFolder folder;
  const auto file = [&](const char* name) { return (folder / name).string(); };
  {
    std::ofstream out(file("states.csv")), at(file("points.csv"));
    out << std::setprecision(17);
    at << std::setprecision(17);
    for (const auto& s : states)
      out << s.at[0] << ',' << s.at[1] << ',' << s.at[2] << ',' << s.force[0] << ',' << s.force[1] << ','
          << s.force[2] << '\n';
    for (const auto& p : points) at << p[0] << ',' << p[1] << ',' << p[2] << '\n';
  }
  const std::string script = (source_folder() / "tests/approx/scipy_oracle.py").string();
  const std::string command = "/usr/bin/python3 '" + script + "' " + file("states.csv") + " " +
                              file("points.csv") + " " + std::string(name(kernel)) + " " + std::to_string(n) +
                              " " + file("forces.csv");
  REQUIRE(std::system(command.c_str()) == 0);
  std::ifstream in(file("forces.csv"));
  std::vector<Vec3> forces(points.size());
  char comma;
  for (auto& f : forces) in >> f[0] >> comma >> f[1] >> comma >> f[2];
  REQUIRE(in.good());
  return forces;
}

// linear and cubic, of all states and of the 100 nearest.
void check_against_scipy(const StateSpace& space, const std::vector<State>& states,
                         const std::vector<Vec3>& points) {
  for (const Kernel kernel : {Kernel::linear, Kernel::cubic})
    for (const std::size_t n : {std::size_t{0}, std::size_t{100}}) {
      CAPTURE(name(kernel), n);
      const auto expected = scipy_forces(states, points, kernel, n);
      ModelUpdater updater(
          space, {.kernel = kernel, .neighbours = n == 0 ? states.size() : n, .select = Select::nearest});
      double worst = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Model model = updater.model_at(points[i]);
        worst = std::max(worst,
                         (model.force(points[i]) - expected[i]).norm() / std::max(expected[i].norm(), 0.05));
      }
      CHECK(worst < 1e-9);
    }
}

StateSpace space_of(const std::vector<State>& states, double spacing) {
  StateSpaceOptions options;
  options.spacing = spacing;
  StateSpace space(options);
  for (const auto& s : states) space.insert(s);
  return space;
}

}  // namespace

TEST_CASE("linear and cubic on force equal SciPy's RBFInterpolator of degree 1",
          "[scipy]" SLOW("compares with SciPy, which only run.sh all installs")) {
  if (!has_python_module("scipy.interpolate")) return skip("python3-scipy is not installed");
  const auto states = states_at(lattice_points(4, 0.006));
  std::vector<Vec3> points;
  std::mt19937 random(17);
  std::uniform_real_distribution<double> inside(-0.024, 0.024), outside(-0.033, 0.033);
  for (int i = 0; i < 40; ++i) points.emplace_back(inside(random), inside(random), inside(random));
  for (int i = 0; i < 20; ++i) points.emplace_back(outside(random), outside(random), outside(random));
  check_against_scipy(space_of(states, 0.006), states, points);
}

TEST_CASE("The same on a liver's states, of all and of the 100 nearest",
          "[scipy]" SLOW("compares with SciPy, which only run.sh all installs")) {
  if (!has_python_module("scipy.interpolate")) return skip("python3-scipy is not installed");
  auto body = std::make_shared<Body>();
  body->mesh = phantom("liver");
  body->clamp = body->mesh.groups.at("clamp");
  body->contact = body->mesh.groups.at("contact");
  LatticeOptions generate;
  generate.spacing = 0.008;
  generate.box = {Vec3::Constant(-0.024), Vec3::Constant(0.024)};
  generate.threads = 1;
  std::vector<State> states;
  generate_lattice(body, generate, [&](State s) { states.push_back(std::move(s)); });
  REQUIRE(states.size() > 300);
  const StateSpace space = space_of(states, generate.spacing);
  std::vector<Vec3> points;
  std::mt19937 random(23);
  std::uniform_real_distribution<double> anywhere(-0.03, 0.03);
  std::vector<StateId> nearest;
  while (points.size() < 40) {
    const Vec3 x(anywhere(random), anywhere(random), anywhere(random));
    space.nearest(x, 101, nearest);  // rounding must not decide which 100 are nearest
    if ((space[nearest[100]].at - x).norm() - (space[nearest[99]].at - x).norm() > 1e-9) points.push_back(x);
  }
  check_against_scipy(space, states, points);
}
