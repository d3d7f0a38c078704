// forefeel bench solver hard-cases: where static solves are hard, one row a case: how it ended, iterations, least
// det F, whether another way ends elsewhere, time. A Markdown table on stdout, or rows with --json.

#include <fmt/format.h>
#include <omp.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>

#include "apps/bench_hard_cases.hpp"
#include "apps/scene_body.hpp"
#include "geometry/phantom.hpp"
#include "solver/solver.hpp"

namespace forefeel {
namespace {

struct HardCase {
  std::string group, contact, motion;
  std::shared_ptr<const Body> body;
  Vec3 at = Vec3::Zero();
  double spacing = 0.006;
  SolveOutcome outcome;
  bool other_branch = false;
};

constexpr Law laws[] = {Law::linear, Law::st_venant_kirchhoff, Law::neo_hookean, Law::stable_neo_hookean, Law::mooney_rivlin};

std::shared_ptr<Body> liver(bool one_node) {
  auto body = std::make_shared<Body>();
  body->mesh = phantom("liver");
  body->clamp = body->mesh.groups.at("clamp");
  body->contact = body->mesh.groups.at("contact");
  if (one_node) body->contact = {nearest_surface_node(body->mesh, phantom_tip("liver"))};
  return body;
}

// Press 6 cm inward, pull 6 cm outward, shear 4 cm along the surface.
void add_grid(std::vector<HardCase>& cases) {
  for (const bool one_node : {true, false}) {
    const auto plain = liver(one_node);
    const Vec3 inward = inward_direction(*plain), along = inward.unitOrthogonal();
    for (const Law law : laws)
      for (const double poisson : {0.3, 0.45, 0.49, 0.499}) {
        auto body = std::make_shared<Body>(*plain);
        body->material.law = law;
        body->material.poisson = poisson;
        const char* contact = one_node ? "one node" : "2 cm patch";
        cases.push_back({"liver", contact, "press 6 cm", body, 0.06 * inward, 0.006, {}, false});
        cases.push_back({"liver", contact, "pull 6 cm", body, -0.06 * inward, 0.006, {}, false});
        cases.push_back({"liver", contact, "shear 4 cm", body, 0.04 * along, 0.006, {}, false});
      }
  }
}

void add_scaled(std::vector<HardCase>& cases) {
  const auto plain = liver(false);
  const Vec3 inward = inward_direction(*plain);
  for (const double length : {1e-3, 10.0}) {
    auto body = std::make_shared<Body>(*plain);
    scale_to_length(body->mesh, length);
    cases.push_back({fmt::format("liver {} m long", length), "2 cm patch, scaled", "press by 0.15 of it", body, 0.15 * length * inward, 0.03 * length, {}, false});
  }
  for (const double young : {1.0, 1e9}) {
    auto body = std::make_shared<Body>(*plain);
    body->material.young = young;
    cases.push_back({fmt::format("liver, E = {} Pa", young), "2 cm patch", "press 3 cm", body, 0.03 * inward, 0.006, {}, false});
  }
  auto sliver = std::make_shared<Body>(*plain);      // flattened until its flattest tetrahedra have about a degree
  for (double share = 1; quality(sliver->mesh).min_dihedral_deg > 1.0 && share > 1e-3; share *= 0.8)
    for (Vec3& node : sliver->mesh.nodes) node[2] *= 0.8;
  cases.push_back({fmt::format("liver flattened to slivers of {:.2f} deg", quality(sliver->mesh).min_dihedral_deg), "patch", "pull 1 mm", sliver, -0.001 * inward, 0.001, {}, false});
}

void add_beams(std::vector<HardCase>& cases) {
  auto beam = std::make_shared<Body>();
  beam->mesh = phantom("beam");
  beam->clamp = beam->mesh.groups.at("clamp");
  beam->contact = beam->mesh.groups.at("contact");
  auto thin = std::make_shared<Body>(*beam);
  for (Vec3& node : thin->mesh.nodes) node[2] *= 0.2;
  cases.push_back({"beam a fifth as thick", "patch", "bend 3 cm", thin, Vec3(0, 0, 0.03), 0.003, {}, false});
  auto near = std::make_shared<Body>(*beam);         // the free surface node nearest to a clamped one
  double least = 1e300;
  for (const NodeIndex node : surface_nodes(near->mesh)) {
    if (std::binary_search(near->clamp.begin(), near->clamp.end(), node)) continue;
    for (const NodeIndex held : near->clamp) {
      const double distance = (near->mesh.nodes[static_cast<std::size_t>(node)] - near->mesh.nodes[static_cast<std::size_t>(held)]).norm();
      if (distance >= least) continue;
      least = distance;
      near->contact = {node};
    }
  }
  cases.push_back({"beam, contact beside the clamp", "one node", "pull 0.9 of the distance", near, 0.9 * least * Vec3(0.6, 0.6, 0.53), 0.001, {}, false});
}

void solve(HardCase& c) {
  Solver solver(c.body);
  c.outcome = solver.reference(c.at, c.spacing, {.max_iterations = 40});
  c.other_branch = second_way_differs(solver, c.outcome.state, c.spacing, {.max_iterations = 40});
}

nlohmann::ordered_json to_json(const HardCase& c) {
  const State& s = c.outcome.state;
  nlohmann::ordered_json row;
  row["body"] = c.group;
  row["contact"] = c.contact;
  row["motion"] = c.motion;
  row["law"] = name(c.body->material.law);
  row["young"] = c.body->material.young;
  row["poisson"] = c.body->material.poisson;
  row["status"] = name(s.status);
  row["converged"] = s.status == SolveStatus::converged;
  row["iterations"] = s.iterations;
  row["residual"] = number(s.residual);
  row["min_jacobian"] = number(s.min_jacobian);
  row["force"] = vector3(s.force);
  row["multivalued"] = c.other_branch;
  row["seconds"] = number(s.seconds);
  row["warnings"] = c.outcome.warnings;
  return row;
}

}  // namespace

int bench_hard_cases(const Globals& globals) {
  std::vector<HardCase> cases;
  add_grid(cases);
  add_scaled(cases);
  add_beams(cases);
  const int threads = globals.threads > 0 ? globals.threads : omp_get_max_threads();
  Progress progress(globals, "hard cases");
  std::size_t done = 0;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (std::size_t i = 0; i < cases.size(); ++i) {
    solve(cases[i]);
#pragma omp critical(forefeel_hard_cases)
    progress.show(static_cast<double>(++done) / static_cast<double>(cases.size()), fmt::format("{} of {}", done, cases.size()));
  }
  nlohmann::ordered_json document{{"rows", nlohmann::ordered_json::array()}};
  say(globals, "| body | contact | motion | law | nu | ended | iterations | least J | other branch | ms |");
  say(globals, "|---|---|---|---|---|---|---|---|---|---|");
  std::size_t converged = 0;
  for (const HardCase& c : cases) {
    const State& s = c.outcome.state;
    converged += s.status == SolveStatus::converged;
    document["rows"].push_back(to_json(c));
    say(globals, fmt::format("| {} | {} | {} | {} | {} | {} | {} | {:.3f} | {} | {:.0f} |", c.group, c.contact, c.motion,
                             name(c.body->material.law), c.body->material.poisson, name(s.status), s.iterations,
                             s.min_jacobian, c.other_branch ? "yes" : "no", 1e3 * s.seconds));
  }
  document["cases"] = cases.size();
  document["converged"] = converged;
  if (globals.json) print_json(document);
  say(globals, fmt::format("\n{} of {} cases converged.", converged, cases.size()));
  return 0;
}

}  // namespace forefeel
