// FEniCSx as an oracle for bodies of several materials, on the same mesh with the same quadrature.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "region_body.hpp"
#include "solver/body/law.hpp"
#include "solver/kernels/kernels.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/skip.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace forefeel;

namespace {

constexpr int steps = 3;

nlohmann::json described(const Body& body, const std::vector<Vec3>& at) {
  nlohmann::json document{{"degree", body.element == Element::quadratic ? 2 : 1}, {"steps", steps}};
  document["clamp"] = {{0, 0, 0}, {0, 0.04, 0.04}};
  document["contact"] = {{0.1, 0.04, 0}, {0.1, 0.04, 0.04}};
  for (const Vec3& x : body.mesh.nodes) document["nodes"].push_back({x[0], x[1], x[2]});
  for (const Tet& tet : body.mesh.tets) document["tets"].push_back(tet);
  for (const Vec3& x : at) document["at"].push_back({x[0], x[1], x[2]});
  const std::size_t n = body.mesh.tets.size();
  std::vector<int> law(n);
  std::vector<double> mu(n), lambda(n);
  for (const MaterialPart& part : material_parts(body))
    for (const TetIndex tet : part.tets) {
      const LawConstants constants = law_constants(part.material);
      const auto t = static_cast<std::size_t>(tet);
      law[t] = part.material.law == Law::linear ? 0 : part.material.law == Law::st_venant_kirchhoff ? 1 : 2;
      mu[t] = constants.mu;
      lambda[t] = constants.lambda;
    }
  document["law"] = law;
  document["mu"] = mu;
  document["lambda"] = lambda;
  return document;
}

}  // namespace

TEST_CASE("FEniCSx: two and three materials, factors of 10 and 1000, forces within 1e-9") {
  if (!test::has_python_module("dolfinx")) return test::skip("python3-dolfinx is not installed");
  constexpr Law nh = Law::neo_hookean, svk = Law::st_venant_kirchhoff, linear = Law::linear;
  const Material soft{nh, 5e3, 0.4}, stiff_end{linear, 5e6, 0.3};
  std::vector<std::shared_ptr<Body>> bodies{
      region_body(soft, {nh, 5e4, 0.4}),
      region_body(soft, {nh, 5e6, 0.4}),
      region_body(soft, {nh, 5, 0.4}),
      region_body({svk, 5e3, 0.4}, {svk, 5e4, 0.4}),
      region_body({svk, 5e3, 0.4}, {svk, 5e6, 0.4}),
      region_body({nh, 5e3, 0.2}, {nh, 5e3, 0.499}),
      region_body({nh, 5e3, 0.2}, {svk, 5e4, 0.45}, &stiff_end, 2),
      region_body(soft, {nh, 5e6, 0.3}, nullptr, 1, Element::quadratic),
      region_body({nh, 5e3, 0.2}, {svk, 5e4, 0.45}, &stiff_end, 1, Element::quadratic)};
  const std::vector<Vec3> at{Vec3(-0.004, 0.006, 0.003), Vec3(0.008, -0.009, 0.002)};
  nlohmann::json input;
  for (const auto& body : bodies) input.push_back(described(*body, at));
  const test::TemporaryFolder folder;
  std::ofstream(folder / "bodies.json") << input;
  const std::string command = "OMP_NUM_THREADS=1 /usr/bin/python3 '" +
                              (test::source_folder() / "tests/solver/fenicsx_oracle.py").string() + "' '" +
                              (folder / "bodies.json").string() + "' '" + (folder / "out.json").string() +
                              "' > '" + (folder / "log").string() + "' 2>&1";
  REQUIRE(std::system(command.c_str()) == 0);
  const auto theirs = nlohmann::json::parse(std::ifstream(folder / "out.json"));
  REQUIRE(theirs.size() == bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    Solver solver(bodies[b]);
    for (std::size_t i = 0; i < at.size(); ++i) {
      const Vec3 force(theirs[b][i][0], theirs[b][i][1], theirs[b][i][2]);
      const State ours =
          solver.reference(at[i], at[i].norm() / steps * (1 + 1e-9), {.tolerance = 1e-12}).state;
      REQUIRE(ours.solve.status == SolveStatus::converged);
      INFO("body " << b << ": " << ours.force.transpose() << ", FEniCSx " << force.transpose() << ", off by "
                   << (ours.force - force).norm() / force.norm());
      CHECK((ours.force - force).norm() < 1e-9 * force.norm());
    }
  }
}
