// forefeel mesh SURFACE -o OUT.msh: repairs, decimates and fills a surface; or meshes a label volume; or makes a
// phantom; or cleans a volume mesh.

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <optional>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/document_keys.hpp"
#include "apps/console/json.hpp"
#include "apps/console/look_at_it.hpp"
#include "apps/console/outputs.hpp"
#include "apps/console/values.hpp"
#include "apps/mesh/extent.hpp"
#include "apps/mesh/mesh_labels.hpp"
#include "apps/mesh/mesh_toward.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/mesh/length_unit.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/meshing/deviation.hpp"
#include "geometry/meshing/phantom.hpp"
#include "geometry/meshing/remeshed_body.hpp"
#include "geometry/meshing/size_field.hpp"
#include "geometry/meshing/tetrahedralise.hpp"
#include "geometry/segmentation/label_volume.hpp"

namespace forefeel {
namespace {

struct MeshArguments {
  std::string input, output, phantom, labels, unit, toward;
  std::optional<long long> elements;
  std::optional<double> length, time_limit;
};

struct MadeMesh {
  TetMesh mesh;
  TetrahedraliseReport report;
  bool repaired = false;                                            // true if a surface was repaired
  double hausdorff = std::numeric_limits<double>::quiet_NaN();      // [m]
  double volume_change = std::numeric_limits<double>::quiet_NaN();  // (mesh - surface) / surface
  std::vector<std::string> warnings;
  std::optional<LabelBody> labels = {};   // of a label volume; its mesh is moved to the one above
  std::optional<MadeToward> toward = {};  // where it is graded
};

void check_arguments(const MeshArguments& arguments) {
  if (arguments.input.empty() == arguments.phantom.empty())
    throw InputError("mesh", arguments.input.empty()
                                 ? "no surface given, expected a file or --phantom NAME"
                                 : "both a file and --phantom given, expected one of them");
  if (!arguments.labels.empty() && !is_label_volume_file(arguments.input))
    throw InputError("--labels", fmt::format("needs a label volume, expected {}", label_volume_extensions));
  if (!is_written_mesh(arguments.output))
    throw InputError(arguments.output, "expected a name that ends in .msh or .vtu");
  if (arguments.elements && (*arguments.elements < 1 || *arguments.elements > 20'000'000))
    throw InputError("--elements",
                     fmt::format("{} is out of range, expected 1 to 20000000", *arguments.elements));
  if (arguments.length && !(*arguments.length > 0 && std::isfinite(*arguments.length)))
    throw InputError("--length", fmt::format("{} m, expected a positive number", *arguments.length));
  if (!arguments.unit.empty() && !unit_of(arguments.unit))
    throw InputError("--unit", fmt::format("'{:.40}', expected {}{}", arguments.unit, unit_names,
                                           arguments.unit.starts_with("in")
                                               ? "; of a body in inches, admesh --scale=25.4 makes one in mm"
                                               : ""));
  if (!arguments.unit.empty() && (arguments.length || !arguments.phantom.empty()))
    throw InputError("--unit", arguments.length ? "has no effect with --length, expected one of them"
                                                : "a phantom has its size in m, expected --length");
  if (!arguments.toward.empty()) {
    parse_toward(arguments.toward);
    if (is_label_volume_file(arguments.input))
      throw InputError("--toward", "needs a surface, a volume mesh or a phantom, expected no label volume");
    if (!arguments.elements && arguments.phantom.empty())
      throw InputError("--toward", "needs the number of elements, expected --elements N");
  }
  check_writable(arguments.output);
}

// Of the lengths of a surface or mesh [m].
double unit_in(const MeshArguments& arguments) {
  return unit_of(arguments.unit).value_or(1);
}

// "filling it with tetrahedra: surface 2 of at most 14, 9 meshes tried"
std::string in_words(const MeshingProgress& p) {
  std::string text = name(p.step);
  if (p.attempt > 0) text += fmt::format(": surface {} of at most {}", p.attempt, p.attempts);
  if (p.fills > 0) text += fmt::format(", {} mesh{} tried", p.fills, p.fills == 1 ? "" : "es");
  return text;
}

Surface scaled(Surface surface, double factor) {
  for (Vec3& node : surface.nodes) node *= factor;
  return surface;
}

// Of a surface that is scaled to a length afterwards; the place counts in the scaled one.
void take_to_surface(const Surface& surface, const MeshArguments& arguments, const std::string& name,
                     MadeMesh& made) {
  if (arguments.toward.empty()) return;
  const double side = bounding_box(surface).size().maxCoeff();
  made.toward = on_surface(parse_toward(arguments.toward),
                           arguments.length ? scaled(surface, *arguments.length / side) : surface);
  if (const auto words = far_off(*made.toward)) made.warnings.push_back(name + ": --toward: " + *words);
}

TetrahedraliseOptions options_of(const MeshArguments& arguments, const std::string& name,
                                 const MadeMesh& made) {
  TetrahedraliseOptions options{.elements = static_cast<std::size_t>(arguments.elements.value_or(0)),
                                .length = arguments.length,
                                .name = name,
                                .time_limit = arguments.time_limit};
  if (made.toward) options.toward = made.toward->toward;
  return options;
}

MadeMesh from_phantom(const MeshArguments& arguments) {
  MadeMesh made{.mesh = {}, .report = {}, .warnings = {}};
  const auto elements = static_cast<std::size_t>(arguments.elements.value_or(0));
  if (arguments.toward.empty()) {
    made.mesh = phantom(arguments.phantom, elements);
    if (arguments.length) scale_to_length(made.mesh, *arguments.length);
    return made;
  }
  const Surface surface = phantom_surface(arguments.phantom);
  take_to_surface(surface, arguments, "phantom " + arguments.phantom, made);
  const double factor = arguments.length ? *arguments.length / bounding_box(surface).size().maxCoeff() : 1;
  SizeField size;
  made.mesh =
      graded_phantom(arguments.phantom,
                     {.elements = elements,
                      .toward = {made.toward->toward.site / factor, made.toward->toward.radius / factor}},
                     &size);
  for (Vec3& node : made.mesh.nodes) node *= factor;
  made.toward->near = factor * size.near, made.toward->far = factor * size.far;
  return made;
}

// What the mesh has lost of the surface.
void judge(MadeMesh& made, const Surface& surface, const MeshArguments& arguments, const std::string& name) {
  if (made.toward) made.toward->near = made.report.near, made.toward->far = made.report.far;
  made.hausdorff = made.report.hausdorff;
  if (made.report.repair.wrapped)
    made.warnings.push_back(
        fmt::format("{}: the surface could not be repaired in place and was rebuilt around", name));
  const Deviation deviation =
      deviation_of(surface, made.mesh, made.hausdorff, arguments.length, made.report.repair);
  made.volume_change = deviation.volume_change;
  for (const std::string& words : in_words(deviation, made.report.repair))
    made.warnings.push_back(fmt::format("{}: {}", name, words));
}

MadeMesh from_surface(const Surface& surface, const MeshArguments& arguments, const std::string& name,
                      Progress& progress) {
  MadeMesh made{.mesh = {}, .report = {}, .repaired = true, .warnings = {}};
  take_to_surface(surface, arguments, name, made);
  made.mesh = tetrahedralise(surface, options_of(arguments, name, made), &made.report,
                             [&](const MeshingProgress& p) { progress.show(in_words(p)); });
  for (const std::string& remark : surface.remarks) made.warnings.push_back(name + ": " + remark);
  judge(made, surface, arguments, name);
  return made;
}

// The new mesh of a volume mesh, with its groups.
MadeMesh from_volume(const TetMesh& mesh, const MeshArguments& arguments) {
  MadeMesh made{.mesh = {}, .report = {}, .repaired = true, .warnings = {}};
  const Surface surface = boundary_surface(mesh);
  take_to_surface(surface, arguments, arguments.input, made);
  made.mesh = remeshed(mesh, options_of(arguments, arguments.input, made), &made.report);
  judge(made, surface, arguments, arguments.input);
  return made;
}

MadeMesh from_labels(const MeshArguments& arguments, Progress& progress) {
  LabelMeshOptions options{.length = arguments.length, .time_limit = arguments.time_limit};
  if (!arguments.labels.empty()) options.labels = parse_labels(arguments.labels);
  if (arguments.elements) options.elements = static_cast<std::size_t>(*arguments.elements);
  MadeMesh made{.mesh = {}, .report = {}, .warnings = {}};
  made.labels = body_of_labels(arguments.input, options, arguments.unit, progress);
  made.mesh = std::move(made.labels->mesh);
  made.hausdorff = made.labels->report.hausdorff;
  for (const std::string& warning : made.labels->report.warnings)
    made.warnings.push_back(arguments.input + ": " + warning);
  return made;
}

MadeMesh make(const Globals& globals, const MeshArguments& arguments) {
  // How long a surface takes is not known beforehand: the line gives the step, and the time so far.
  Progress progress(globals, "mesh");
  const std::string wanted =
      arguments.elements ? fmt::format("to {} elements", *arguments.elements) : std::string("as it is");
  progress.show(arguments.phantom.empty()
                    ? fmt::format("repairing and filling {} {}", arguments.input, wanted)
                    : fmt::format("making the phantom {}", arguments.phantom));
  if (!arguments.phantom.empty()) return from_phantom(arguments);
  if (is_label_volume_file(arguments.input)) return from_labels(arguments, progress);
  if (is_surface_file(arguments.input))
    return from_surface(scaled(read_surface(arguments.input), unit_in(arguments)), arguments, arguments.input,
                        progress);
  if (!is_mesh_file(arguments.input) && std::filesystem::exists(arguments.input))
    throw InputError(arguments.input,
                     "unknown kind of file, expected a surface (.obj .off .stl .ply .vtk), a mesh "
                     "(.msh .vtk .vtu .mesh) or a label volume (.nii .nii.gz .mha .nrrd .vti)" +
                         converter_for(arguments.input));
  TetMesh mesh = read_mesh(arguments.input);
  for (Vec3& node : mesh.nodes) node *= unit_in(arguments);
  MeshCheck check = check_and_orient(mesh, arguments.input);
  MadeMesh made{.mesh = {}, .report = {}, .warnings = {}};
  if (!arguments.toward.empty()) {
    made = from_volume(mesh, arguments);
  } else if (arguments.elements) {
    made = from_surface(boundary_surface(mesh), arguments, arguments.input, progress);
  } else {
    if (arguments.length) scale_to_length(mesh, *arguments.length);
    made.mesh = std::move(mesh);
    made.hausdorff = 0;
  }
  for (const std::string& warning : check.warnings) made.warnings.push_back(arguments.input + ": " + warning);
  return made;
}

const JsonKeys<RepairReport>& repair_keys() {
  using R = RepairReport;
  static const JsonKeys<R> keys{
      {"self_intersections", "", "pairs of triangles that intersected", &R::self_intersections},
      {"holes", "", "holes that were closed", &R::holes},
      {"components", "", "connected parts of the input", &R::components},
      {"crossing", "", "parts that crossed another one", &R::crossing},
      {"united", "", "true: the body is the union of these", &R::united},
      {"reoriented", "", "true: triangles were turned", &R::reoriented},
      {"wrapped", "", "true: the surface was wrapped anew, since it could not be repaired", &R::wrapped},
      {"triangles_before", "", "of the input", &R::triangles_before},
      {"triangles_after", "", "of the repaired surface", &R::triangles_after}};
  return keys;
}

struct WrittenMesh {
  const MadeMesh& made;
  const MeshSummary& sum;
  const std::string& file;
};

Json groups_json(const WrittenMesh& written) {
  Json groups = Json::object();
  for (const auto& [name, nodes] : written.sum.groups) groups[name] = nodes;
  return groups;
}

const JsonKeys<WrittenMesh>& mesh_keys() {
  using W = WrittenMesh;
  static const JsonKeys<W> keys{
      {"nodes", "", "number of nodes", [](const W& w) { return w.sum.nodes; }},
      {"elements", "", "number of tetrahedra", [](const W& w) { return w.sum.elements; }},
      {"volume", "m^3", "of the mesh", [](const W& w) { return w.sum.quality.volume; }},
      {"min_dihedral_deg", "degrees", "least angle between two faces of a tetrahedron",
       [](const W& w) { return w.sum.quality.min_dihedral_deg; }},
      {"max_dihedral_deg", "degrees", "largest", [](const W& w) { return w.sum.quality.max_dihedral_deg; }},
      {"hausdorff", "m", "distance between the surface of the mesh and the input; null: not measured",
       [](const W& w) { return w.made.hausdorff; }},
      {"volume_change", "1", "volume of the mesh over that of the input, less 1; null: not measured",
       [](const W& w) { return w.made.volume_change; }},
      json_object<W>(
          "repaired", repair_keys(), "empty where no surface was repaired",
          [](const W& w) { return w.made.repaired ? &w.made.report.repair : nullptr; }, Json::object()),
      json_object<W>(
          "toward", toward_keys(), "empty where the mesh is not graded",
          [](const W& w) { return w.made.toward ? &*w.made.toward : nullptr; }, Json::object()),
      {"min_tet_volume", "m^3", "of the smallest tetrahedron",
       [](const W& w) { return w.sum.quality.min_tet_volume; }},
      {"longest_side", "m", "of the bounding box", [](const W& w) { return w.sum.box.size().maxCoeff(); }},
      {"box", "m", "low and high corner", [](const W& w) { return box_json(w.sum.box); }},
      {"surface_triangles", "", "of the mesh", [](const W& w) { return w.sum.surface_triangles; }},
      {"groups.NAME", "", "nodes of each named set; groups is empty without sets", groups_json},
      {"groups", "", "object of the named sets"},
      json_list<W>("labels", label_keys(),
                   [](const W& w) {
                     return w.made.labels ? std::optional(w.made.labels->report.regions) : std::nullopt;
                   })
          .last(),
      {"file", "", "that was written", [](const W& w) { return w.file; }},
      {"warnings", "", "list of lines", [](const W& w) { return w.made.warnings; }}};
  return keys;
}

void tell(const Globals& globals, const MadeMesh& made, const MeshSummary& sum, const std::string& output) {
  say(globals,
      fmt::format(
          "{}: {} tetrahedra, {} nodes, {:.4g} m long, {:.4g} cm3, dihedral angles {:.1f} to {:.1f} degrees",
          output, sum.elements, sum.nodes, sum.box.size().maxCoeff(), 1e6 * sum.quality.volume,
          sum.quality.min_dihedral_deg, sum.quality.max_dihedral_deg));
  say(globals, "within " + box_text(sum.box));
  if (made.toward) say(globals, in_words(*made.toward));
  if (made.labels) tell_labels(globals, *made.labels);
  if (!made.repaired) return;
  const RepairReport& r = made.report.repair;
  say(globals, fmt::format("surface: {} triangles, {} self-intersections, {} holes, {} part{}; Hausdorff "
                           "distance {:.3g} mm, volume {}",
                           r.triangles_before, r.self_intersections, r.holes, r.components,
                           r.components == 1 ? "" : "s", 1e3 * made.hausdorff,
                           std::isfinite(made.volume_change)
                               ? fmt::format("{:+.1f} %", 100 * made.volume_change)
                               : std::string("of the surface unknown, since it is open")));
}

// A mesh from TetGen or from a coarse grid must pass the checks for meshes that are read. What fails then is the
// mesher's, not the file's.
void check_made(MadeMesh& made, const MeshArguments& arguments) {
  const std::string where = arguments.phantom.empty() ? arguments.input : "phantom " + arguments.phantom;
  try {
    check_and_orient(made.mesh, where);
  } catch (const InputError& error) {
    throw InputError(where,
                     fmt::format("the mesh made of it cannot be solved: {}; expected another --elements",
                                 error.problem()));
  }
}

// Most files name no unit, and a unit may be mistaken. Nothing to say where the person has chosen the size.
void warn_of_size(MadeMesh& made, const Box& box, const MeshArguments& arguments) {
  if (arguments.length || !arguments.phantom.empty()) return;
  const double own = made.labels ? made.labels->unit : 1;
  const std::string size = unlikely_size(box, unit_of(arguments.unit).value_or(own));
  if (!size.empty())
    made.warnings.push_back(fmt::format("{}: {}; --unit or --length scales it", arguments.input, size));
}

int run_mesh(const Globals& globals, const MeshArguments& arguments) {
  if (!globals.set.empty())
    throw InputError("--set", "is about keys of a scene, but mesh reads none, expected no --set");
  check_arguments(arguments);
  MadeMesh made = make(globals, arguments);
  check_made(made, arguments);
  const MeshSummary sum = summarise(made.mesh);
  warn_of_size(made, sum.box, arguments);
  write_mesh(arguments.output, made.mesh);
  for (const std::string& warning : made.warnings) warn(globals, warning);
  if (globals.json) print_json(document_of(mesh_keys(), WrittenMesh{made, sum, arguments.output}));
  tell(globals, made, sum, arguments.output);
  say(globals, look_at_it(globals, arguments.output));
  return 0;
}

}  // namespace

DeclaredTable mesh_output() {
  return {"mesh.json", "Of mesh --json.", declared(mesh_keys())};
}

void add_mesh(CommandLine& line) {
  auto arguments = std::make_shared<MeshArguments>();
  Command sub = line.add(
      "mesh", "Make a tetrahedral mesh from a surface, a label volume, a volume mesh or a built-in body");
  sub.runs([arguments](const Globals& globals) { return run_mesh(globals, *arguments); });
  sub.option("SURFACE", arguments->input,
             "Surface (.obj .off .stl .ply .vtk), label volume (.nii .nii.gz .mha .nrrd .vti) or mesh "
             "(.msh .vtk .vtu .mesh)")
      .shows("SURFACE");
  sub.option("-o,--output", arguments->output, "Mesh to write: Gmsh 2.2 (.msh) or VTK (.vtu)")
      .required()
      .shows("OUT.msh");
  sub.option("--elements", arguments->elements, "Number of tetrahedra, met within 5 % [label volume: 20000]")
      .shows("N");
  sub.option("--labels", arguments->labels,
             "Labels of a label volume and names of their groups, 1=liver,7=tumour [all, as label_7]")
      .shows("LABEL=NAME,...");
  sub.option("--unit", arguments->unit,
             "Unit of the file's lengths: m, cm, mm or um [m; label volume: its own, or mm]")
      .shows("UNIT");
  sub.option("--length", arguments->length, "Scale so that the longest side is this [m]").shows("M");
  sub.option("--time-limit", arguments->time_limit,
             "Time for the surface, all tries together [s] [120; for above 600000 elements N/5000]")
      .check(above_zero)
      .shows("S");
  sub.option(
         "--toward", arguments->toward,
         "Small elements at a contact: its place, taken to the surface, and its radius [m], in the axes of "
         "the mesh made [even elements]")
      .shows("X,Y,Z,R");
  sub.option("--phantom", arguments->phantom, "Built-in body: liver, beam, ball or slab").shows("NAME");
}

}  // namespace forefeel
