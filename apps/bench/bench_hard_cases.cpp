// forefeel bench solver hard-cases: static solves that are hard, one row per case: outcome, iterations, least
// det F, time, and whether another loading path ends at another equilibrium. An equilibrium with an inverted
// element does not count as converged. Prints a Markdown table, or rows with --json.

#include <fmt/format.h>
#include <omp.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/bench/bench_hard_cases.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/json_text.hpp"
#include "apps/console/provenance.hpp"
#include "apps/picture/page.hpp"
#include "apps/scene/scene_body.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/result_folder.hpp"
#include "geometry/meshing/phantom.hpp"
#include "geometry/states/state_outcome.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {
namespace {

struct HardCase {
  std::string group, contact, motion;
  std::shared_ptr<const Body> body;
  Vec3 at = Vec3::Zero();
  double spacing = 0.006;
  SolveOutcome outcome;
  std::optional<bool> other_branch;
};
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
    for (const Law law : all_laws())
      for (const double poisson : {0.3, 0.45, 0.49, 0.499}) {
        auto body = std::make_shared<Body>(*plain);
        body->material.law = law;
        body->material.poisson = poisson;
        const char* contact = one_node ? "one node" : "2 cm patch";
        cases.push_back({"liver", contact, "press 6 cm", body, 0.06 * inward, 0.006, {}, {}});
        cases.push_back({"liver", contact, "pull 6 cm", body, -0.06 * inward, 0.006, {}, {}});
        cases.push_back({"liver", contact, "shear 4 cm", body, 0.04 * along, 0.006, {}, {}});
      }
  }
}

void add_scaled(std::vector<HardCase>& cases) {
  const auto plain = liver(false);
  const Vec3 inward = inward_direction(*plain);
  for (const double length : {1e-3, 10.0}) {
    auto body = std::make_shared<Body>(*plain);
    scale_to_length(body->mesh, length);
    cases.push_back({fmt::format("liver {} m long", length),
                     "2 cm patch, scaled",
                     "press by 0.15 of it",
                     body,
                     0.15 * length * inward,
                     0.03 * length,
                     {},
                     {}});
  }
  for (const double young : {1.0, 1e9}) {
    auto body = std::make_shared<Body>(*plain);
    body->material.young = young;
    cases.push_back({fmt::format("liver, E = {:g} Pa", young),
                     "2 cm patch",
                     "press 3 cm",
                     body,
                     0.03 * inward,
                     0.006,
                     {},
                     {}});
  }
  auto sliver =
      std::make_shared<Body>(*plain);  // flattened until its flattest tetrahedra have about a degree
  for (double share = 1; mesh_quality(sliver->mesh).min_dihedral_deg > 1.0 && share > 1e-3; share *= 0.8)
    for (Vec3& node : sliver->mesh.nodes) node[2] *= 0.8;
  cases.push_back(
      {fmt::format("liver flattened to slivers of {:.2f} deg", mesh_quality(sliver->mesh).min_dihedral_deg),
       "patch",
       "pull 1 mm",
       sliver,
       -0.001 * inward,
       0.001,
       {},
       {}});
}

void add_beams(std::vector<HardCase>& cases) {
  auto beam = std::make_shared<Body>();
  beam->mesh = phantom("beam");
  beam->clamp = beam->mesh.groups.at("clamp");
  beam->contact = beam->mesh.groups.at("contact");
  auto thin = std::make_shared<Body>(*beam);
  for (Vec3& node : thin->mesh.nodes) node[2] *= 0.2;
  cases.push_back({"beam a fifth as thick", "patch", "bend 3 cm", thin, Vec3(0, 0, 0.03), 0.003, {}, {}});
  auto near = std::make_shared<Body>(*beam);  // contact: the free surface node nearest to a clamped node
  double least = 1e300;
  for (const NodeIndex node : surface_nodes(near->mesh)) {
    if (std::binary_search(near->clamp.begin(), near->clamp.end(), node)) continue;
    for (const NodeIndex held : near->clamp) {
      const double distance = (near->mesh.nodes[static_cast<std::size_t>(node)] -
                               near->mesh.nodes[static_cast<std::size_t>(held)])
                                  .norm();
      if (distance >= least) continue;
      least = distance;
      near->contact = {node};
    }
  }
  cases.push_back({"beam, contact beside the clamp",
                   "one node",
                   "pull 0.9 of the distance",
                   near,
                   0.9 * least * Vec3(0.6, 0.6, 0.53),
                   0.001,
                   {},
                   {}});
}

void solve(HardCase& c) {
  Solver solver(c.body);
  c.outcome = solver.reference(c.at, c.spacing);
  c.other_branch = second_way(solver, c.outcome.state, c.spacing);
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
  row["status"] = name(outcome(s));
  row["converged"] = outcome(s) == SolveStatus::converged;
  row["iterations"] = s.solve.iterations;
  row["residual"] = number(s.solve.residual);
  row["min_jacobian"] = number(s.solve.min_jacobian);
  row["force"] = vector3(s.force);
  row["multivalued"] = c.other_branch ? nlohmann::ordered_json(*c.other_branch) : nlohmann::ordered_json();
  row["seconds"] = number(s.solve.seconds);
  row["warnings"] = c.outcome.warnings;
  return row;
}

constexpr const char* columns[] = {"body",  "contact",    "motion",  "law",          "nu",
                                   "ended", "iterations", "least J", "other branch", "ms"};

std::vector<std::string> cells(const HardCase& c) {
  const State& s = c.outcome.state;
  return {c.group,
          c.contact,
          c.motion,
          std::string(name(c.body->material.law)),
          fmt::format("{}", c.body->material.poisson),
          has_inverted_elements(s) ? "inverted elements" : std::string(name(s.solve.status)),
          fmt::format("{}", s.solve.iterations),
          fmt::format("{:.3f}", s.solve.min_jacobian),
          !c.other_branch   ? "unknown"
          : *c.other_branch ? "yes"
                            : "no",
          fmt::format("{:.0f}", 1e3 * s.solve.seconds)};
}

// hard_cases.csv and hard_cases.html in the folder.
void write_report(const std::filesystem::path& folder, const std::vector<HardCase>& cases,
                  const std::string& summary) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed || !std::filesystem::is_directory(folder))
    throw InputError({.file = folder.string()}, "cannot be made, expected a folder to write the report to");
  claim_folder(folder, {"hard_cases.csv", "hard_cases.html"});
  OutputFile table(folder / "hard_cases.csv"), page(folder / "hard_cases.html");
  std::string head, rows;
  for (const char* column : columns) {
    table.write(fmt::format("{}{}", column == columns[0] ? "" : ",", column));
    head += fmt::format("<th>{}</th>", column);
  }
  table.write("\n");
  for (const HardCase& c : cases) {
    std::string row;
    for (const std::string& cell : cells(c)) {
      const bool comma = cell.find(',') != std::string::npos;
      table.write(
          fmt::format("{}{}{}{}", row.empty() ? "" : ",", comma ? "\"" : "", cell, comma ? "\"" : ""));
      row += fmt::format("<td>{}</td>", html_escaped(cell));
    }
    table.write("\n");
    rows += "<tr>" + row + "</tr>\n";
  }
  page.write(html_page(
      "Forefeel: hard cases",
      fmt::format(
          "<h1>Hard cases</h1>\n<p>{} Each is solved from rest in steps of its spacing. \"Other branch\" "
          "tells whether a way along the axes, one after the other, ends in another stable "
          "equilibrium; unknown where that way does not arrive. Least J is the least det F over "
          "the elements.</p>\n<table><tr>{}</tr>\n{}</table>\n<p>{}</p>",
          html_escaped(summary), head, rows, html_escaped(json_text(provenance(""))))));
  table.commit();
  page.commit();
}

}  // namespace

int bench_hard_cases(const Globals& globals, const std::string& output) {
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
    progress.show(static_cast<double>(++done) / static_cast<double>(cases.size()),
                  fmt::format("{} of {}", done, cases.size()));
  }
  nlohmann::ordered_json document{{"rows", nlohmann::ordered_json::array()}};
  std::size_t converged = 0, inverted = 0;
  for (const HardCase& c : cases) {
    converged += outcome(c.outcome.state) == SolveStatus::converged;
    inverted += has_inverted_elements(c.outcome.state);
    document["rows"].push_back(to_json(c));
  }
  document["cases"] = cases.size();
  document["converged"] = converged;
  document["inverted"] = inverted;
  document["failed"] = cases.size() - converged - inverted;
  const std::string summary =
      fmt::format("{} of {} cases converged, {} reached an equilibrium with inverted elements, {} failed.",
                  converged, cases.size(), inverted, cases.size() - converged - inverted);
  if (!output.empty()) write_report(output, cases, summary);
  if (globals.json) print_json(document);
  say(globals, fmt::format("| {} |", fmt::join(columns, " | ")));
  say(globals, "|---|---|---|---|---|---|---|---|---|---|");
  for (const HardCase& c : cases) say(globals, fmt::format("| {} |", fmt::join(cells(c), " | ")));
  say(globals, "\n" + summary);
  return 0;
}

}  // namespace forefeel
