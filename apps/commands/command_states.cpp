// forefeel import, export and info: read states, write states, show the content of a file.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/classify/repeated_states.hpp"
#include "apps/commands/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/surface.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;

// ---- import ----------------------------------------------------------------------------------------------

struct ImportArguments {
  std::string input, output;
  double spacing = 0;
};

Box box_of(const std::vector<State>& states) {
  if (states.empty()) return {};
  Box box{states.front().at, states.front().at};
  for (const State& s : states) box.low = box.low.cwiseMin(s.at), box.high = box.high.cwiseMax(s.at);
  return box;
}

// An imported file may be imported again. A file with solved states is never overwritten.
void refuse_solved(const std::string& output) {
  std::error_code error;
  if (!std::filesystem::exists(output, error) || std::filesystem::file_size(output, error) == 0) return;
  const StateFile file = StateFile::open_read_only(output);
  const auto source = file.header().notes.find("source");
  if (file.size() > 0 && (source == file.header().notes.end() || !source->second.starts_with("import")))
    throw InputError(
        output,
        fmt::format("already holds {} states that were not imported, expected a new name", file.size()));
}

int run_import(const Globals& globals, const ImportArguments& arguments) {
  if (!(arguments.spacing > 0) || !std::isfinite(arguments.spacing))
    throw InputError("--spacing", fmt::format("{} m, expected a positive number", arguments.spacing));
  const std::vector<State> states = read_states_csv(arguments.input);
  check_writable(arguments.output, {arguments.input});
  refuse_solved(arguments.output);
  StateFileHeader header;
  header.spacing = arguments.spacing;
  header.box = box_of(states);
  header.notes["source"] = "import " + arguments.input;
  StateFile file = StateFile::open_or_create(arguments.output, header);
  file.replace(header, states);
  const std::size_t repeated = repeated_states(states).repeated;
  const auto with_stiffness = std::ranges::count_if(states, &State::has_stiffness);
  if (repeated > 0)
    warn(globals, fmt::format("{}: {} duplicate positions; the first is kept", arguments.input, repeated));
  if (globals.json)
    print_json({{"states", states.size()},
                {"with_stiffness", with_stiffness},
                {"repeated", repeated},
                {"spacing", number(header.spacing)},
                {"box", {vector3(header.box.low), vector3(header.box.high)}},
                {"file", arguments.output}});
  say(globals, fmt::format("{}: {} states, {} with stiffness, spacing {:g} mm", arguments.output,
                           states.size(), with_stiffness, 1e3 * header.spacing));
  return 0;
}

// ---- export ----------------------------------------------------------------------------------------------

struct ExportArguments {
  std::string input, output;
};

int run_export(const Globals& globals, const ExportArguments& arguments) {
  const std::string extension = lower_case(std::filesystem::path(arguments.output).extension().string());
  if (extension != ".csv" && extension != ".vtu")
    throw InputError(arguments.output, "expected a name that ends in .csv or .vtu");
  check_writable(arguments.output, {arguments.input});
  const LoadedStates loaded = load_states(arguments.input);
  if (loaded.damaged > 0) warn(globals, damage_in_words(arguments.input, loaded.damaged));
  const auto usable = static_cast<std::size_t>(std::ranges::count_if(loaded.states, &State::usable));
  const std::size_t written = extension == ".csv" ? usable : loaded.states.size();
  if (extension == ".csv")
    write_states_csv(arguments.output, loaded.states);
  else
    write_states_vtu(arguments.output, loaded.states);
  if (globals.json)
    print_json({{"states", loaded.states.size()},
                {"written", written},
                {"failed_left_out", loaded.states.size() - written},
                {"file", arguments.output}});
  say(globals, fmt::format("{}: {} states{}", arguments.output, written,
                           written < loaded.states.size()
                               ? fmt::format(", {} that failed left out", loaded.states.size() - written)
                               : ""));
  return 0;
}

// ---- info ------------------------------------------------------------------------------------------------

Json box_json(const Box& box) {
  return Json::array({vector3(box.low), vector3(box.high)});
}

std::string size_text(const Vec3& size) {
  return fmt::format("{:.4g} x {:.4g} x {:.4g} m", size.x(), size.y(), size.z());
}

int info_states(const Globals& globals, const std::string& file) {
  const LoadedStates loaded = load_states(file);
  if (loaded.damaged > 0) warn(globals, damage_in_words(file, loaded.damaged));
  std::map<std::string, std::size_t> by_status;
  std::size_t stiff = 0, energetic = 0, displaced = 0, multivalued = 0, usable = 0;
  double strongest = 0, seconds = 0;
  for (const State& s : loaded.states) {
    ++by_status[std::string(name(s.status))];
    multivalued += s.multivalued;
    if (std::isfinite(s.seconds)) seconds += s.seconds;
    if (!s.usable()) continue;
    ++usable;
    stiff += s.has_stiffness(), energetic += std::isfinite(s.energy), displaced += s.displacements != nullptr;
    strongest = std::max(strongest, s.force.norm());
  }
  const Box extent = box_of(loaded.states);
  const std::size_t contradicting = repeated_states(loaded.states).contradicting;
  if (contradicting > 0)
    warn(globals, fmt::format("{}: {} another at the same position; the first is kept", file,
                              contradicting == 1 ? "1 state contradicts"
                                                 : fmt::format("{} states contradict", contradicting)));
  if (globals.json) {
    Json document{{"kind", "states"},
                  {"states", loaded.states.size()},
                  {"usable", usable},
                  {"failed", loaded.states.size() - usable}};
    document["by_status"] = Json(by_status);
    document["with_stiffness"] = stiff;
    document["with_energy"] = energetic;
    document["with_displacements"] = displaced;
    document["multivalued"] = multivalued;
    document["contradicting"] = contradicting;
    document["spacing"] = number(loaded.header.spacing);
    document["box"] = box_json(loaded.header.box);
    document["extent"] = box_json(extent);
    document["max_force"] = number(strongest);
    document["solve_seconds"] = number(seconds);
    document["identity"] = Json(loaded.header.identity);
    document["notes"] = Json(loaded.header.notes);
    document["bytes"] = std::filesystem::file_size(file);
    print_json(document);
  }
  answer(globals,
         fmt::format(
             "{}: {} states ({} failed), {} with stiffness, spacing {}, within {}, forces up to {:.4g} N",
             file, loaded.states.size(), loaded.states.size() - usable, stiff,
             std::isfinite(loaded.header.spacing) ? fmt::format("{:g} mm", 1e3 * loaded.header.spacing)
                                                  : "unknown",
             size_text(extent.size()), strongest));
  for (const auto& [key, value] : loaded.header.identity)
    answer(globals, fmt::format("  {}: {}", key, value));
  if (const auto note = loaded.header.notes.find("spacing"); note != loaded.header.notes.end())
    answer(globals, "  " + note->second);
  return 0;
}

int info_mesh(const Globals& globals, const std::string& file) {
  TetMesh mesh = read_mesh(file);
  const MeshCheck check = check_and_orient(mesh, file);
  const MeshQuality measured = mesh_quality(mesh);
  const std::vector<int> part = components(mesh);
  const int parts = 1 + *std::ranges::max_element(part);
  const std::size_t on_surface = surface_nodes(mesh).size();
  for (const std::string& warning : check.warnings) warn(globals, file + ": " + warning);
  if (globals.json) {
    Json document{{"kind", "mesh"},
                  {"nodes", mesh.nodes.size()},
                  {"elements", mesh.tets.size()},
                  {"volume", number(measured.volume)}};
    document["min_dihedral_deg"] = number(measured.min_dihedral_deg);
    document["max_dihedral_deg"] = number(measured.max_dihedral_deg);
    document["min_tet_volume"] = number(measured.min_tet_volume);
    document["longest_side"] = number(longest_side(mesh));
    document["box"] = box_json(bounding_box(mesh));
    document["components"] = parts;
    document["surface_nodes"] = on_surface;
    document["surface_triangles"] = boundary_triangles(mesh).size();
    document["groups"] = Json::object();
    for (const auto& [group, nodes] : mesh.groups) document["groups"][group] = nodes.size();
    document["warnings"] = check.warnings;
    print_json(document);
  }
  answer(globals, fmt::format("{}: {} tetrahedra, {} nodes ({} on the surface), {} part{}, {}, {:.4g} cm3, "
                              "dihedral angles {:.1f} to {:.1f} degrees",
                              file, mesh.tets.size(), mesh.nodes.size(), on_surface, parts,
                              parts == 1 ? "" : "s", size_text(bounding_box(mesh).size()),
                              1e6 * measured.volume, measured.min_dihedral_deg, measured.max_dihedral_deg));
  for (const auto& [group, nodes] : mesh.groups)
    answer(globals, fmt::format("  group {}: {} nodes", group, nodes.size()));
  return 0;
}

int info_surface(const Globals& globals, const std::string& file) {
  const Surface surface = read_surface(file);
  std::map<std::pair<NodeIndex, NodeIndex>, int> edges;
  for (const Triangle& t : surface.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
  const auto border = std::ranges::count_if(edges, [](const auto& edge) { return edge.second == 1; });
  const auto crowded = std::ranges::count_if(edges, [](const auto& edge) { return edge.second > 2; });
  const bool closed = border == 0 && crowded == 0;
  const Box box = bounding_box(surface);
  if (globals.json)
    print_json({{"kind", "surface"},
                {"nodes", surface.nodes.size()},
                {"triangles", surface.triangles.size()},
                {"closed", closed},
                {"border_edges", border},
                {"non_manifold_edges", crowded},
                {"volume", closed ? number(enclosed_volume(surface)) : Json(nullptr)},
                {"longest_side", number(box.size().maxCoeff())},
                {"box", box_json(box)}});
  answer(globals, fmt::format("{}: {} triangles, {} nodes, {}, {} (unscaled)", file, surface.triangles.size(),
                              surface.nodes.size(),
                              closed ? "closed"
                                     : fmt::format("open: {} border edges, {} shared by more than two",
                                                   border, crowded),
                              size_text(box.size())));
  return 0;
}

int run_info(const Globals& globals, const std::string& file) {
  const std::string start = read_start(file, 16);  // reports a file that is missing, a folder or empty
  if (start.starts_with("SQLite format 3")) return info_states(globals, file);
  if (is_mesh_file(file)) return info_mesh(globals, file);
  if (is_surface_file(file)) return info_surface(globals, file);
  const std::string extension = lower_case(std::filesystem::path(file).extension().string());
  if (extension == ".csv" || extension == ".states") return info_states(globals, file);
  throw InputError(file,
                   "unknown kind of file, expected states (.states .csv), a mesh (.msh .vtk .vtu .mesh) or a "
                   "surface (.obj .off .stl .ply)");
}

}  // namespace

void add_import(CommandLine& line) {
  auto arguments = std::make_shared<ImportArguments>();
  Command sub =
      line.add("import", "Convert states from a CSV, measured or from elsewhere, into a state file");
  sub.runs([arguments](const Globals& globals) { return run_import(globals, *arguments); });
  sub.option("csv", arguments->input, "Columns x,y,z,fx,fy,fz[,k11,…,k33][,h]").required().shows("F.csv");
  sub.option("-o,--output", arguments->output, "State file to write").required().shows("S.states");
  sub.option("--spacing", arguments->spacing, "Spacing h that counts as fully populated [m]")
      .required()
      .shows("H");
}

void add_export(CommandLine& line) {
  auto arguments = std::make_shared<ExportArguments>();
  Command sub = line.add("export", "Write states as a table or for ParaView");
  sub.runs([arguments](const Globals& globals) { return run_export(globals, *arguments); });
  sub.option("states", arguments->input, "State file or CSV").required().shows("STATES");
  sub.option("-o,--output", arguments->output, "File to write").required().shows("F.csv|F.vtu");
}

void add_info(CommandLine& line) {
  auto file = std::make_shared<std::string>();
  Command sub = line.add("info", "Show what a file holds: states, mesh or surface");
  sub.runs([file](const Globals& globals) { return run_info(globals, *file); });
  sub.option("file", *file, "State file, CSV of states, mesh or surface").required().shows("FILE");
}

}  // namespace forefeel
