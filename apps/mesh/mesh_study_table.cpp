#include "apps/mesh/mesh_study_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>
#include <utility>

#include "apps/console/document_keys.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/console/json_text.hpp"
#include "apps/console/outputs.hpp"
#include "apps/console/provenance.hpp"
#include "apps/picture/figure.hpp"
#include "apps/picture/plot.hpp"
#include "apps/scene/scene.hpp"
#include "apps/scene/scene_mesh_error.hpp"
#include "geometry/common/csv_columns.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/result_folder.hpp"
#include "solver/body/refined_body.hpp"
#include "solver/equilibrium/mesh_study.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;
using Rows = std::vector<MeshStudyRow>;

constexpr std::int64_t most_nodes = 22'000;  // of a body that is solved
constexpr double multiples[] = {0.25, 0.5, 2, 4};

// A mesh of the scene's body, and whether it is one of its own or refined from the scene's.
struct Candidate {
  std::shared_ptr<const Body> body;
  bool remeshed = false;
};

// Null where the scene's mesh cannot be made with another number of elements.
std::shared_ptr<const Body> remeshed(const Globals& globals, const std::string& file, std::size_t elements) {
  std::vector<std::string> overrides = globals.set;
  overrides.push_back(fmt::format("body.elements={}", elements));
  try {
    return load_scene(file, overrides, nullptr, {.spacing = false, .quiet = true}).body;
  } catch (const InputError&) {
    return nullptr;
  }
}

// Numbers of nodes mean another place on another mesh.
bool names_nodes(const Scene& scene) {
  for (const char* key : {"\nnode ", "\nnode=", "\nnodes ", "\nnodes="})
    if (scene.source.body.find(key) != std::string::npos) return true;
  return false;
}

std::vector<Candidate> meshes_of(const Globals& globals, const Scene& scene, const std::string& file,
                                 Progress& progress) {
  std::vector<Candidate> meshes{{scene.body}};
  for (int level = 0; level < 2; ++level)
    if (estimated_nodes_refined(*meshes.back().body) <= most_nodes || level == 0)
      meshes.push_back({std::make_shared<const Body>(refined(*meshes.back().body))});
  if (names_nodes(scene)) return meshes;
  for (const double multiple : multiples) {
    end_if_interrupted("the meshes were made");
    const auto wanted =
        static_cast<std::size_t>(multiple * static_cast<double>(scene.body->mesh.tets.size()));
    progress.show(0.2 * multiple / 8, fmt::format("meshing {} elements", wanted));
    const auto body = remeshed(globals, file, wanted);
    if (!body) break;
    meshes.push_back({body, true});
  }
  return meshes;
}

// Each mesh with linear and with quadratic elements, unless that is too large.
Rows solved(const std::vector<Candidate>& meshes, const Vec3& x, Progress& progress) {
  Rows rows;
  for (const Element element : {Element::linear, Element::quadratic})
    for (const Candidate& mesh : meshes) {
      end_if_interrupted("all bodies were solved");
      auto body = std::make_shared<Body>(*mesh.body);
      body->element = element;
      if (estimated_nodes(*body) > most_nodes) continue;
      progress.show(0.2 + 0.4 * (element == Element::linear ? 0 : 1),
                    fmt::format("{} {} elements", body->mesh.tets.size(), name(element)));
      rows.push_back(study_row(body, x));
      rows.back().remeshed = mesh.remeshed;
    }
  std::ranges::stable_sort(rows, {}, [](const MeshStudyRow& row) {
    return std::tuple(row.element == Element::quadratic, row.elements);
  });
  return rows;
}

struct MeshStudyFindings {
  Rows rows;
  MeshLimit limit;
  std::optional<std::size_t> best;
  Vec3 at = Vec3::Zero();
};

nlohmann::ordered_json row_json(const MeshStudyRow& row) {
  return {{"elements", row.elements},       {"element", name(row.element)}, {"nodes", row.nodes},
          {"force", number(row.force)},     {"error", number(row.error)},   {"work", number(row.work)},
          {"seconds", number(row.seconds)}, {"remeshed", row.remeshed}};
}

nlohmann::ordered_json to_json(const MeshStudyFindings& found, double error) {
  nlohmann::ordered_json document{{"rows", nlohmann::ordered_json::array()}};
  for (const MeshStudyRow& row : found.rows) document["rows"].push_back(row_json(row));
  document["at"] = vector3(found.at);
  document["force"] = number(found.limit.force);
  document["beyond"] = number(found.limit.beyond);
  document["uncertainty"] = number(found.limit.uncertainty);
  document["rates"] = {{"linear", number(found.limit.rate[0])}, {"quadratic", number(found.limit.rate[1])}};
  document["error"] = error;
  document["cheapest"] = found.best ? row_json(found.rows[*found.best]) : nlohmann::ordered_json();
  return document;
}

std::string digits(double value) {
  return std::isfinite(value) ? fmt::format("{:.9g}", value) : std::string();
}

const CsvColumns<MeshStudyRow>& study_columns() {
  using R = MeshStudyRow;
  static const CsvColumns<R> columns{
      {"elements", "", "tetrahedra", [](const R& r) { return std::to_string(r.elements); }},
      {"element", "", "linear or quadratic", [](const R& r) { return std::string(name(r.element)); }},
      {"nodes", "", "of the elements, mid-edge nodes included",
       [](const R& r) { return std::to_string(r.nodes); }},
      {"force", "N", "|K x| at the position, K the stiffness at rest; empty where rest is not stable",
       [](const R& r) { return digits(r.force); }},
      {"error", "1", "against the extrapolated force", [](const R& r) { return digits(r.error); }},
      {"work", "", "multiplications of a factorisation", [](const R& r) { return digits(r.work); }},
      {"seconds", "s", "time of the factorisation and its solves",
       [](const R& r) { return digits(r.seconds); }},
      {"remeshed", "", "true: a mesh of its own; false: the scene's, or refined from it",
       [](const R& r) { return std::string(r.remeshed ? "true" : "false"); }}};
  return columns;
}

std::string csv_of(const Rows& rows) {
  std::string text = csv_header(study_columns());
  for (const MeshStudyRow& row : rows) text += csv_row(study_columns(), row);
  return text;
}

std::string script_of(const MeshStudyFindings& found, double error) {
  std::string blocks[2];
  for (const MeshStudyRow& row : found.rows)
    if (row.error > 0)
      blocks[row.element == Element::linear ? 0 : 1] += fmt::format("{} {}\n", row.elements, 100 * row.error);
  return data_block("linear", blocks[0]) + data_block("quadratic", blocks[1]) +
         fmt::format(
             "set logscale xy\nset grid\nset xlabel 'tetrahedra'\nset ylabel 'error of the force [%]'\n"
             "set key top right\nplot $linear with linespoints pt 7 ps 0.7 lw 2 lc rgb '{}' title 'linear', "
             "$quadratic with linespoints pt 5 ps 0.7 lw 2 lc rgb '{}' title 'quadratic', {} with lines dt 2 "
             "lc rgb '{}' title 'wanted'\n",
             ink("undamped"), ink("reference"), 100 * error, ink("limit"));
}

void tell(const Globals& globals, const MeshStudyFindings& found, double error) {
  say(globals, "| tetrahedra | elements | nodes | force [N] | error | ms |");
  say(globals, "|---|---|---|---|---|---|");
  for (const MeshStudyRow& row : found.rows)
    say(globals,
        fmt::format("| {}{} | {} | {} | {:.5g} | {:.2g} % | {:.0f} |", row.elements, row.remeshed ? "" : " *",
                    name(row.element), row.nodes, row.force, 100 * row.error, 1e3 * row.seconds));
  if (!found.limit.known()) return;
  say(globals,
      fmt::format(
          "extrapolated force {:.5g} N, uncertain by {:.2g} %, at ({:.3g}, {:.3g}, {:.3g}) m, {:.2g} % "
          "beyond the nearest of these",
          found.limit.force, 100 * found.limit.uncertainty, found.at[0], found.at[1], found.at[2],
          100 * found.limit.beyond));
  if (found.best) {
    const MeshStudyRow& row = found.rows[*found.best];
    say(globals, fmt::format("cheapest below {:g} %: {} {} elements ({} nodes), {:.2g} %", 100 * error,
                             row.elements, name(row.element), row.nodes, 100 * row.error));
  }
}

}  // namespace

DeclaredTable mesh_study_output() {
  return {"mesh_study.csv", "What mesh --study writes: one row a body.", declared(study_columns())};
}

int study_meshes(const Globals& globals, const MeshStudyArguments& arguments) {
  const fs::path folder = arguments.folder;
  const Scene scene = load_scene(arguments.scene, globals.set, nullptr, {.spacing = false});
  claim_folder(folder, {"mesh_study.csv", "mesh_study.svg", "summary.json"});
  std::optional<Progress> progress(std::in_place, globals, "mesh study");
  const double spacing = scene.space.spacing;
  MeshStudyFindings found;
  found.at = mesh_error_positions(scene.space.box, scene.inward, spacing).front();
  found.rows = solved(meshes_of(globals, scene, arguments.scene, *progress), found.at, *progress);
  progress.reset();
  found.limit = extrapolated(found.rows);
  compare(found.rows, found.limit);
  found.best = cheapest(found.rows, arguments.error);
  nlohmann::ordered_json document = to_json(found, arguments.error);
  document["provenance"] = provenance(scene.source.hash);
  write_whole(folder / "mesh_study.csv", csv_of(found.rows));
  write_whole(folder / "summary.json", json_text(document, 2) + "\n");
  const auto picture = draw_svg("mesh_study", 640, 420, script_of(found, arguments.error));
  if (picture)
    write_whole(folder / "mesh_study.svg", *picture);
  else
    warn(globals, "mesh_study.svg: not drawn, gnuplot was not found or failed");
  if (globals.json) print_json(document);
  tell(globals, found, arguments.error);
  if (found.limit.uncertainty > arguments.error)
    warn(globals,
         fmt::format("the extrapolated force is uncertain by {:.2g} %, more than the error of {:g} %",
                     100 * found.limit.uncertainty, 100 * arguments.error));
  if (!found.limit.known())
    warn(globals, "fewer than two meshes could be solved: the error is not known");
  else if (!found.best)
    warn(globals, fmt::format("no body that was tried has an error below {:g} %", 100 * arguments.error));
  return found.best ? 0 : 1;
}

}  // namespace forefeel
