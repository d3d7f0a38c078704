// forefeel info: shows what a file holds: states, a mesh or a surface.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/document_keys.hpp"
#include "apps/console/json.hpp"
#include "apps/console/outputs.hpp"
#include "apps/console/units.hpp"
#include "apps/files/info_run.hpp"
#include "apps/mesh/extent.hpp"
#include "apps/scene/palpation_map.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_contact.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/mesh/length_unit.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/meshing/surface.hpp"
#include "geometry/segmentation/label_volume.hpp"
#include "geometry/states/misleading.hpp"
#include "geometry/states/state_file.hpp"
#include "geometry/states/state_summary.hpp"
#include "solver/body/fine_jet.hpp"

namespace forefeel {

namespace {

// What `forefeel info SCENE` says: the body, its contact, and the fine body that corrects it.

using Json = nlohmann::ordered_json;

Json fine_json(const Scene& scene) {
  const Body& body = *scene.body;
  if (scene.touch.anywhere && scene.touch.anywhere->fine)
    return {{"body", scene.identity.at("fine")}, {"radius", nullptr}};
  if (!body.fine) return nullptr;
  return {{"body", body.fine->fine_body()}, {"radius", number(body.fine->radius())}};
}

// A checksum of 64 digits by its first twelve; --json has all.
std::string shortened(const std::string& text) {
  std::string out = text;
  for (std::size_t from = 0; from < out.size(); ++from) {
    const std::size_t end = std::min(out.find_first_not_of("0123456789abcdef", from), out.size());
    if (end - from >= 64) out.erase(from + 12, end - from - 12);
    from += std::min<std::size_t>(end - from, 12);
  }
  return out;
}

int info_scene(const Globals& globals, const std::string& file) {
  const Scene scene = load_scene_with_sites(file, globals.set, {.spacing = false, .quiet = globals.quiet});
  const Body& body = *scene.body;
  for (const std::string& warning : scene.source.warnings) warn(globals, warning);
  const ContactNote contact = contact_note(scene);
  std::optional<FieldNote> field;
  if (is_anywhere(scene)) field = field_note(scene, find_field(scene, globals), globals);
  if (globals.json)
    print_json({{"kind", "scene"},
                {"element", name(body.element)},
                {"elements", body.mesh.tets.size()},
                {"nodes", body.mesh.nodes.size()},
                {"clamped_nodes", body.clamp.size()},
                {"contact", document_of(contact_keys(), contact)},
                {"field", field ? document_of(field_keys(), *field) : Json()},
                {"fine", fine_json(scene)},
                {"accuracy", scene.source.accuracy ? Json(in_words(*scene.source.accuracy)) : Json()},
                {"identity", Json(scene.identity)},
                {"warnings", scene.source.warnings}});
  answer(globals, fmt::format("{}: {} {} elements, {} nodes, {} of them clamped", file, body.mesh.tets.size(),
                              name(body.element), body.mesh.nodes.size(), body.clamp.size()));
  if (field) {
    answer(globals, fmt::format("  contact: a pad of {:g} N/m and {:g} mm, anywhere", contact.stiffness,
                                1e3 * contact.radius));
    for (const std::string& line : in_words(*field)) answer(globals, "  " + line);
  } else if (contact.pad) {
    answer(globals,
           fmt::format(
               "  contact: a pad of {:g} N/m and {:g} mm over {:.3g} cm2; its springs amount to {:.4g} N/m",
               contact.stiffness, 1e3 * contact.radius, 1e4 * contact.area, contact.springs));
    answer(globals, fmt::format("  pressed in by 10 mm, {} of its springs' force pulls; at 45 degrees {}",
                                in_percent(contact.pulling_share[0]), in_percent(contact.pulling_share[1])));
  } else {
    answer(globals, fmt::format("  contact: {} nodes that move with the tip, {:.3g} cm2", body.contact.size(),
                                1e4 * contact.area));
  }
  if (contact.place) {
    const auto& [at, n] = *contact.place;
    answer(globals,
           fmt::format("  the tip rests at ({:.4g}, {:.4g}, {:.4g}) mm of the mesh, where the outward normal "
                       "is ({:.3g}, {:.3g}, {:.3g})",
                       1e3 * at[0], 1e3 * at[1], 1e3 * at[2], n[0], n[1], n[2]));
  }
  if (scene.source.accuracy) answer(globals, "  body.accuracy: " + in_words(*scene.source.accuracy));
  if (field && scene.touch.anywhere->fine)
    answer(globals,
           fmt::format("  the field is that of a fine body ({})", shortened(scene.identity.at("fine"))));
  if (body.fine)
    answer(
        globals,
        fmt::format("  corrected by a fine body ({}), fully to {:.3g} mm from rest, less and less to {:.3g}",
                    shortened(body.fine->fine_body()), 1e3 * FineJet::trusted_share * body.fine->radius(),
                    1e3 * body.fine->radius()));
  return 0;
}

// What `forefeel info` says of a label volume: voxels, their size, where the axes point, and the labels.

constexpr std::size_t most_shown = 255;  // labels; more are probably no labels

// A warning where a body has an unlikely size. taken: the unit of its lengths, as they were taken [m].
std::vector<std::string> size_warning(const Box& box, const char* scaled_by, double taken = 1) {
  const std::string size = unlikely_size(box, taken);
  if (size.empty()) return {};
  return {fmt::format("{}; {}", size, scaled_by)};
}

// About what is not the background, along the voxels [m].
Box body_in(const LabelVolume& volume) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::int64_t k = 0; k < volume.size[2]; ++k)
    for (std::int64_t j = 0; j < volume.size[1]; ++j)
      for (std::int64_t i = 0; i < volume.size[0]; ++i) {
        if (volume.values[volume.voxels[volume.at(i, j, k)]] == 0) continue;
        const Vec3 voxel(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        low = low.cwiseMin(voxel), high = high.cwiseMax(voxel + Vec3::Ones());
      }
  const Vec3 sizes = volume.axes.colwise().norm().transpose();
  return low.allFinite() ? Box{sizes.cwiseProduct(low), sizes.cwiseProduct(high)} : Box{};
}

int info_labels(const Globals& globals, const std::string& file) {
  LabelVolume volume = read_label_volume(file);
  if (!volume.unit_unknown.empty())
    throw InputError({.file = file}, fmt::format("its unit of length '{:.40}' is unknown, expected {}; mesh "
                                                 "takes --unit",
                                                 volume.unit_unknown, unit_names));
  const Vec3 sizes = volume.axes.colwise().norm().transpose();
  std::vector<std::size_t> voxels(volume.values.size(), 0);
  for (const std::uint16_t at : volume.voxels) ++voxels[at];
  std::ranges::copy(
      size_warning(body_in(volume), "forefeel mesh --unit or --length scales it", volume.metres),
      std::back_inserter(volume.warnings));
  for (const std::string& warning : volume.warnings) warn(globals, file + ": " + warning);
  if (globals.json) {
    Json document{{"kind", "labels"},
                  {"voxels", {volume.size[0], volume.size[1], volume.size[2]}},
                  {"voxel_size", vector3(sizes)},
                  {"unit", volume.unit},
                  {"unit_given", volume.unit_given},
                  {"directions", volume.directions},
                  {"labels", Json::array()}};
    for (std::size_t i = 0; i < voxels.size(); ++i)
      document["labels"].push_back({{"label", volume.values[i]},
                                    {"voxels", voxels[i]},
                                    {"volume", static_cast<double>(voxels[i]) * volume.voxel_volume()}});
    document["warnings"] = volume.warnings;
    print_json(document);
  }
  answer(
      globals,
      fmt::format("{}: {} x {} x {} voxels of {:.3g} x {:.3g} x {:.3g} mm; lengths taken in {}{}", file,
                  volume.size[0], volume.size[1], volume.size[2], 1e3 * sizes[0], 1e3 * sizes[1],
                  1e3 * sizes[2], volume.unit,
                  volume.unit_given || !volume.unit_unknown.empty() ? "" : ", since the file names no unit"));
  if (!volume.directions.empty()) answer(globals, "  x, y, z: " + volume.directions);
  if (volume.values.size() > most_shown)
    warn(
        globals,
        fmt::format("{}: holds {} different values: a scan rather than labels, or an atlas; the first {} are "
                    "shown",
                    file, volume.values.size(), most_shown));
  for (std::size_t i = 0; i < std::min(voxels.size(), most_shown); ++i)
    answer(globals, fmt::format("  label {}: {} voxels, {:.4g} cm3{}", volume.values[i], voxels[i],
                                1e6 * static_cast<double>(voxels[i]) * volume.voxel_volume(),
                                volume.values[i] == 0 ? ", the background" : ""));
  return 0;
}

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
  const LoadedStates loaded = load_states(file, Tells::places);
  if (loaded.damaged > 0) warn(globals, damage_in_words(file, loaded.damaged));
  const StateSetSummary sum = summarise(loaded.states);
  if (const std::string line = contradictions_in_words(file, sum.at_one_position, loaded.states);
      !line.empty())
    warn(globals, line);
  if (loaded.header.identity.empty() && loaded.tells == Tells::force)
    for (const std::string& line : misleading(loaded.states, loaded.header.spacing))
      warn(globals, file + ": " + line);
  if (globals.json) print_json(states_json(sum, loaded.header, file));
  answer(
      globals,
      fmt::format(
          "{}: {} states ({} failed{}), {} with stiffness{}, spacing {}, within {}, {}", file, sum.states,
          sum.states - sum.usable,
          sum.inverted > 0 ? fmt::format(", {} with inverted elements", sum.inverted) : "",
          sum.with_stiffness, sum.with_jet > 0 ? fmt::format(", {} with an energy jet", sum.with_jet) : "",
          std::isfinite(loaded.header.spacing) ? Units(loaded.header.spacing).distance(loaded.header.spacing)
                                               : "unknown",
          size_text(sum.extent.size()),
          loaded.tells == Tells::places  ? "no forces"
          : loaded.tells == Tells::value ? fmt::format("values up to {:.4g} in size", sum.max_force)
                                         : fmt::format("forces up to {:.4g} N", sum.max_force)));
  for (const auto& [key, value] : loaded.header.identity)
    answer(globals, fmt::format("  {}: {}", key, shortened(value)));
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
  const Surface surface = read_surface(file);
  const SurfaceSummary sum = summarise(surface);
  std::vector<std::string> warnings = size_warning(sum.box, "forefeel mesh --unit or --length scales it");
  warnings.insert(warnings.end(), surface.remarks.begin(), surface.remarks.end());
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
  if (std::error_code error; std::filesystem::is_directory(file, error)) return info_run(globals, file);
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
      ".mesh), a surface (.obj .off .stl .ply .vtk) or a label volume (.nii .mha .nrrd .vti)" +
          converter_for(file));
}

}  // namespace

DeclaredTable info_scene_output() {
  DeclaredTable table{"info.json", "Of info SCENE --json, beside what its lines say.", {}};
  for (const std::vector<Declared>& rows :
       {below("contact", declared(contact_keys())), below("field", declared(field_keys()))})
    table.rows.insert(table.rows.end(), rows.begin(), rows.end());
  return table;
}

void add_info(CommandLine& line) {
  auto file = std::make_shared<std::string>();
  Command sub = line.add(
      "info", "Show what a file holds: scene, states, mesh, surface or label volume; or the folder of a run");
  sub.runs([file](const Globals& globals) { return run_info(globals, *file); });
  sub.option("FILE", *file,
             "Scene, state file, CSV of states, mesh, surface, label volume, or folder of a run")
      .required()
      .shows("FILE");
}

}  // namespace forefeel
