// forefeel info: shows what a file holds: states, a mesh or a surface.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/files/info_labels.hpp"
#include "apps/files/info_scene.hpp"
#include "apps/mesh/extent.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/mesh/length_unit.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/meshing/surface.hpp"
#include "geometry/segmentation/label_volume.hpp"
#include "geometry/states/state_file.hpp"
#include "geometry/states/state_summary.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;

Json states_json(const StateSetSummary& sum, const StateFileHeader& header, const std::string& file) {
  Json document{{"kind", "states"},
                {"states", sum.states},
                {"usable", sum.usable},
                {"failed", sum.states - sum.usable}};
  document["by_status"] = Json(sum.by_status);
  document["with_stiffness"] = sum.with_stiffness;
  document["with_energy"] = sum.with_energy;
  document["with_displacements"] = sum.with_displacements;
  document["with_jet"] = sum.with_jet;
  document["multivalued"] = sum.multivalued;
  document["inverted"] = sum.inverted;
  document["contradicting"] = sum.at_one_position.contradicting;
  document["averaged"] = sum.at_one_position.averaged;
  document["largest_difference"] = sum.at_one_position.largest_difference;
  document["spacing"] = number(header.spacing);
  document["box"] = box_json(header.box);
  document["extent"] = box_json(sum.extent);
  document["max_force"] = number(sum.max_force);
  document["solve_seconds"] = number(sum.solve_seconds);
  document["identity"] = Json(header.identity);
  document["notes"] = Json(header.notes);
  document["bytes"] = std::filesystem::file_size(file);
  return document;
}

int info_states(const Globals& globals, const std::string& file) {
  const LoadedStates loaded = load_states(file);
  if (loaded.damaged > 0) warn(globals, damage_in_words(file, loaded.damaged));
  const StateSetSummary sum = summarise(loaded.states);
  if (sum.at_one_position.contradicting > 0)
    warn(globals, contradictions_in_words(file, sum.at_one_position));
  if (globals.json) print_json(states_json(sum, loaded.header, file));
  answer(globals,
         fmt::format(
             "{}: {} states ({} failed{}), {} with stiffness{}, spacing {}, within {}, forces up to {:.4g} N",
             file, sum.states, sum.states - sum.usable,
             sum.inverted > 0 ? fmt::format(", {} with inverted elements", sum.inverted) : "",
             sum.with_stiffness, sum.with_jet > 0 ? fmt::format(", {} with an energy jet", sum.with_jet) : "",
             std::isfinite(loaded.header.spacing) ? fmt::format("{:g} mm", 1e3 * loaded.header.spacing)
                                                  : "unknown",
             size_text(sum.extent.size()), sum.max_force));
  for (const auto& [key, value] : loaded.header.identity)
    answer(globals, fmt::format("  {}: {}", key, value));
  if (const auto note = loaded.header.notes.find("spacing"); note != loaded.header.notes.end())
    answer(globals, "  " + note->second);
  return 0;
}

Json mesh_json(const MeshSummary& sum, const std::vector<std::string>& warnings) {
  Json document{{"kind", "mesh"},
                {"nodes", sum.nodes},
                {"elements", sum.elements},
                {"volume", number(sum.quality.volume)}};
  document["min_dihedral_deg"] = number(sum.quality.min_dihedral_deg);
  document["max_dihedral_deg"] = number(sum.quality.max_dihedral_deg);
  document["min_tet_volume"] = number(sum.quality.min_tet_volume);
  document["longest_side"] = number(sum.box.size().maxCoeff());
  document["box"] = box_json(sum.box);
  document["components"] = sum.components;
  document["surface_nodes"] = sum.surface_nodes;
  document["surface_triangles"] = sum.surface_triangles;
  document["groups"] = Json::object();
  for (const auto& [group, nodes] : sum.groups) document["groups"][group] = nodes;
  document["regions"] = Json::array();
  for (const MeshSummary::Region& region : sum.regions)
    document["regions"].push_back(
        {{"name", region.name}, {"elements", region.elements}, {"volume", number(region.volume)}});
  document["warnings"] = warnings;
  return document;
}

// A warning where a mesh or surface has an unlikely size; its file names no unit.
std::vector<std::string> size_warning(const Box& box, const char* scaled_by) {
  const std::string size = unlikely_size(box);
  if (size.empty()) return {};
  return {fmt::format("{}; {}", size, scaled_by)};
}

int info_mesh(const Globals& globals, const std::string& file) {
  TetMesh mesh = read_mesh(file);
  std::vector<std::string> warnings = check_and_orient(mesh, file).warnings;
  const MeshSummary sum = summarise(mesh);
  std::ranges::copy(size_warning(sum.box, "forefeel mesh --unit, or body.length in a scene, scales it"),
                    std::back_inserter(warnings));
  for (const std::string& warning : warnings) warn(globals, file + ": " + warning);
  if (globals.json) print_json(mesh_json(sum, warnings));
  answer(globals,
         fmt::format("{}: {} tetrahedra, {} nodes ({} on the surface), {} part{}, {}, {:.4g} cm3, "
                     "dihedral angles {:.1f} to {:.1f} degrees",
                     file, sum.elements, sum.nodes, sum.surface_nodes, sum.components,
                     sum.components == 1 ? "" : "s", size_text(sum.box.size()), 1e6 * sum.quality.volume,
                     sum.quality.min_dihedral_deg, sum.quality.max_dihedral_deg));
  answer(globals, "  within " + box_text(sum.box));
  for (const auto& [group, nodes] : sum.groups)
    answer(globals, fmt::format("  group {}: {} nodes", group, nodes));
  for (const MeshSummary::Region& region : sum.regions)
    answer(globals, fmt::format("  region {}: {} tetrahedra, {:.4g} cm3", region.name, region.elements,
                                1e6 * region.volume));
  return 0;
}

int info_surface(const Globals& globals, const std::string& file) {
  const SurfaceSummary sum = summarise(read_surface(file));
  const std::vector<std::string> warnings =
      size_warning(sum.box, "forefeel mesh --unit or --length scales it");
  for (const std::string& warning : warnings) warn(globals, file + ": " + warning);
  if (globals.json)
    print_json({{"kind", "surface"},
                {"nodes", sum.nodes},
                {"triangles", sum.triangles},
                {"closed", sum.closed()},
                {"border_edges", sum.border_edges},
                {"non_manifold_edges", sum.non_manifold_edges},
                {"volume", number(sum.volume)},
                {"longest_side", number(sum.box.size().maxCoeff())},
                {"box", box_json(sum.box)},
                {"warnings", warnings}});
  answer(globals, fmt::format("{}: {} triangles, {} nodes, {}, {} (unscaled)", file, sum.triangles, sum.nodes,
                              sum.closed() ? "closed"
                                           : fmt::format("open: {} border edges, {} shared by more than two",
                                                         sum.border_edges, sum.non_manifold_edges),
                              size_text(sum.box.size())));
  answer(globals, "  within " + box_text(sum.box));
  return 0;
}

int run_info(const Globals& globals, const std::string& file) {
  const std::string start = read_start(file, 16);  // reports a file that is missing, a folder or empty
  if (start.starts_with("SQLite format 3")) return info_states(globals, file);
  if (is_surface_file(file)) return info_surface(globals, file);
  if (is_label_volume_file(file)) return info_labels(globals, file);
  if (is_mesh_file(file)) return info_mesh(globals, file);
  const std::string extension = lower_case(std::filesystem::path(file).extension().string());
  if (extension == ".csv" || extension == ".states") return info_states(globals, file);
  if (extension == ".toml") return info_scene(globals, file);
  throw InputError(
      file,
      "unknown kind of file, expected a scene (.toml), states (.states .csv), a mesh (.msh .vtk .vtu "
      ".mesh), a surface (.obj .off .stl .ply .vtk) or a label volume (.nii .mha .nrrd .vti)");
}

}  // namespace

void add_info(CommandLine& line) {
  auto file = std::make_shared<std::string>();
  Command sub = line.add("info", "Show what a file holds: scene, states, mesh, surface or label volume");
  sub.runs([file](const Globals& globals) { return run_info(globals, *file); });
  sub.option("FILE", *file, "Scene, state file, CSV of states, mesh, surface or label volume")
      .required()
      .shows("FILE");
}

}  // namespace forefeel
