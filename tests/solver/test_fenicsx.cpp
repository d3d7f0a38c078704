// FEniCSx as an oracle for bodies of several materials, and for bodies under a pad, on the same mesh with the same
// quadrature. A pad's matrix is ours (test_pad compares it with other integrals); what the body makes of it is not.

#include "pad_body.hpp"
#include "region_body.hpp"
#include "solver/body/law.hpp"
#include "solver/jet/surface_map.hpp"
#include "solver/kernels/kernels.hpp"
#include "solver/system/discretisation.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr int steps = 3;

json numbers(const Vec3& x) {
  return {x[0], x[1], x[2]};
}

// The springs over nodes at rest and the tip, which comes last.
json described_pad(const Body& body) {
  const Discretisation d = discretise(body);
  const auto tip = static_cast<std::int32_t>(d.free_nodes);
  std::vector<Vec3> place(static_cast<std::size_t>(d.free_nodes) + 2);
  for (std::size_t i = 0; i < d.local.size(); ++i) {
    const std::size_t corners = body.mesh.nodes.size();
    const auto at = [&](NodeIndex node) { return body.mesh.nodes[node]; };
    place[static_cast<std::size_t>(d.local[i])] =
        i < corners ? at(static_cast<NodeIndex>(i))
                    : Vec3(0.5 * (at(d.edges[i - corners][0]) + at(d.edges[i - corners][1])));
  }
  std::map<std::int32_t, std::size_t> number;
  for (const PadSprings::Pair& p : d.elements.pad.pairs)
    for (const std::int32_t node : {p.a, p.b})
      if (node != tip) number.try_emplace(node, number.size());
  json nodes = std::vector<json>(number.size());
  for (const auto& [node, i] : number) nodes[i] = numbers(place[static_cast<std::size_t>(node)]);
  number[tip] = number.size();
  json springs;
  for (const PadSprings::Pair& p : d.elements.pad.pairs)
    springs.push_back({number[p.a], number[p.b], p.stiffness});
  return {{"nodes", nodes}, {"springs", springs}};
}

json described(const Body& body, const std::vector<Vec3>& at) {
  json document{{"degree", body.element == Element::quadratic ? 2 : 1}, {"steps", steps}};
  document["clamp_nodes"] = body.clamp;
  if (body.pad)
    document["pad"] = described_pad(body);
  else
    document["contact"] = {{0.1, 0.04, 0}, {0.1, 0.04, 0.04}};
  for (const Vec3& x : body.mesh.nodes) document["nodes"].push_back(numbers(x));
  for (const Tet& tet : body.mesh.tets) document["tets"].push_back(tet);
  for (const Vec3& x : at) document["at"].push_back(numbers(x));
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

// Compares the forces of all bodies at all positions.
void compare(const std::vector<std::shared_ptr<Body>>& bodies, const std::vector<Vec3>& at, double bound) {
  json input;
  for (const auto& body : bodies) input.push_back(described(*body, at));
  const TemporaryFolder folder;
  std::ofstream(folder / "bodies.json") << input;
  const std::string command = "OMP_NUM_THREADS=1 /usr/bin/python3 '" +
                              (source_folder() / "tests/solver/fenicsx_oracle.py").string() + "' '" +
                              (folder / "bodies.json").string() + "' '" + (folder / "out.json").string() +
                              "' > '" + (folder / "log").string() + "' 2>&1";
  REQUIRE(std::system(command.c_str()) == 0);
  const auto theirs = json::parse(std::ifstream(folder / "out.json"));
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
      CHECK((ours.force - force).norm() < bound * force.norm());
    }
  }
}

}  // namespace

TEST_CASE("FEniCSx: two and three materials, factors of 10 and 1000, forces within 1e-9",
          SLOW("compares with FEniCSx, which only run.sh all installs")) {
  if (!has_python_module("dolfinx")) return skip("python3-dolfinx is not installed");
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
  compare(bodies, at, 1e-9);
}

TEST_CASE("FEniCSx: forces under a pad within 1e-10, linear and quadratic elements",
          SLOW("compares with FEniCSx, which only run.sh all installs")) {
  if (!has_python_module("dolfinx")) return skip("python3-dolfinx is not installed");
  std::vector<std::shared_ptr<Body>> bodies;
  for (const Element element : {Element::linear, Element::quadratic}) {
    bodies.push_back(padded_block(Law::neo_hookean, element));
    bodies.push_back(region_body({Law::neo_hookean, 5e3, 0.2}, {Law::st_venant_kirchhoff, 5e4, 0.45}, nullptr,
                                 1, element));
    bodies.back()->contact.clear();  // a pad at an edge, beside the clamp
    bodies.back()->pad = Pad{.site = Vec3(0.016, 0.04, 0.03), .radius = 0.02, .stiffness = 300};
  }
  compare(bodies, {Vec3(0, 0, -0.01), Vec3(0.005, -0.003, -0.006), Vec3(-0.002, 0.004, 0.006)}, 1e-10);
}

TEST_CASE("FEniCSx: forces under a pad at any site of the surface within 1e-8, neo-Hookean and linear",
          SLOW("compares with FEniCSx, which only run.sh all installs")) {
  if (!has_python_module("dolfinx")) return skip("python3-dolfinx is not installed");
  std::vector<std::shared_ptr<Body>> bodies;
  // Twenty: faces, edges, a corner and places over the clamp of the block of 0.1 x 0.04 x 0.04 m.
  const std::vector<Vec3> sites{
      Vec3(0.03, 0.02, 0.04),   Vec3(0.081, 0.013, 0.04), Vec3(0.05, 0, 0.017),    Vec3(0.06, 0.04, 0.026),
      Vec3(0.1, 0.02, 0.02),    Vec3(0.07, 0.04, 0.04),   Vec3(0.1, 0.031, 0.04),  Vec3(0.1, 0.04, 0.04),
      Vec3(0.012, 0.02, 0.04),  Vec3(0.009, 0.033, 0),    Vec3(0.044, 0.007, 0),   Vec3(0.063, 0.031, 0.04),
      Vec3(0.038, 0, 0.036),    Vec3(0.09, 0, 0.004),     Vec3(0.1, 0.012, 0.028), Vec3(0.1, 0, 0.009),
      Vec3(0.052, 0.04, 0.012), Vec3(0.024, 0.04, 0.039), Vec3(0.074, 0.022, 0),   Vec3(0.1, 0.038, 0.002)};
  for (const Law law : {Law::neo_hookean, Law::linear})
    for (const Vec3& site : sites) {
      bodies.push_back(padded_block(law));
      bodies.back()->pad->site = site;
    }
  compare(bodies, {Vec3(0.002, -0.003, -0.005), Vec3(-0.004, 0.002, 0.003)}, 1e-8);
}

TEST_CASE("FEniCSx: forces under a pad at sites of the smooth surface of a liver within 1e-8",
          SLOW("compares with FEniCSx, which only run.sh all installs")) {
  if (!has_python_module("dolfinx")) return skip("python3-dolfinx is not installed");
  const auto liver = padded_phantom("liver", 600, phantom_tip("liver"));
  const SurfaceMap map(*liver);
  std::mt19937_64 random(21);
  std::vector<std::shared_ptr<Body>> bodies;
  double off_facets = 0;
  for (int i = 0; i < 10; ++i) {
    const SurfacePlace place = map.random(random);
    bodies.push_back(std::make_shared<Body>(*liver));
    bodies.back()->pad->site = place.at;
    off_facets =
        std::max(off_facets, std::abs(map.facet(place).normal.dot(place.at - map.corners(place.facet)[0])));
  }
  CHECK(off_facets > 1e-3);
  compare(bodies, {Vec3(0.002, -0.003, -0.005), Vec3(-0.004, 0.002, 0.003)}, 1e-8);
}
