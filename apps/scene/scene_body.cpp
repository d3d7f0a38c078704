#include "apps/scene/scene_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "apps/console/console.hpp"
#include "apps/scene/phantom_cache.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_declared.hpp"
#include "apps/scene/scene_fine.hpp"
#include "apps/scene/scene_materials.hpp"
#include "apps/scene/scene_nodes.hpp"
#include "geometry/mesh/length_unit.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/phantom.hpp"
#include "geometry/meshing/tetrahedralise.hpp"
#include "solver/body/pad.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t most_elements = 10'000'000;
constexpr std::int64_t most_fine = 100'000;  // a factor of quadratic elements takes 8 GB then

// ---- the mesh

struct FineKeys {
  std::size_t elements = 14'000;
  Element element = Element::quadratic;
};

const SceneRows<FineKeys>& fine_rows() {
  using F = FineKeys;
  static const auto rows =
      SceneRows<F>(
          "body.fine",
          "The fine body, whose energy at rest corrects the body's: body.fine = { elements = 14000 }; false "
          "for none.")
          .whole("elements", 4, most_fine,
                 "its tetrahedra; a volume mesh is subdivided in eights to the nearest number", &F::elements)
          .word("element", element_words, " tetrahedra", &F::element);
  return rows;
}

// { elements, element } or false.
std::optional<FineKeys> read_fine(const SceneTable& body, const std::string& key) {
  if (!body.holds_table(key)) {
    try {
      if (!*body.boolean(key)) return {};
    } catch (const InputError&) {  // neither true nor false
    }
    throw body.wrong(key, "false or a table { elements = N }");
  }
  const SceneTable table = body.sub(key, fine_rows().names());
  FineKeys fine;
  fine_rows().read(table, fine);
  return fine;
}

struct BodyKeys {
  std::string mesh, phantom;
  std::optional<std::size_t> elements;
  std::optional<double> length;  // [m]
  Element element = Body().element;
  std::optional<FineKeys> fine;
  std::optional<bool> uniform;
  std::optional<double> accuracy;
};

constexpr double shortest = 1e-6,
                 longest = 1e6;  // bodies [m]; beyond them sums of squares over- or underflow

const SceneRows<BodyKeys>& rows_of_body() {
  using B = BodyKeys;
  static const auto rows =
      SceneRows<B>("body", "What is pressed. One of mesh and phantom.")
          .text("mesh",
                "volume mesh (.msh .vtk .vtu .mesh), or a surface (.obj .off .stl .ply) with elements",
                &B::mesh)
          .alternative()
          .text("phantom", "built-in body: " + in_words(phantom_names()), &B::phantom)
          .alternative()
          .whole("elements", 4, most_elements, "tetrahedra to make of a surface or a phantom, within 5 %",
                 &B::elements)
          .standard("the phantom's own")
          .number("length", "m", {shortest, longest, false, false, "a number above 0, from 1e-6 to 1e6 [m]"},
                  "longest side to scale the body to", &B::length)
          .standard("as in the file")
          .word("element", element_words,
                " tetrahedra; a mesh of second-order ones is quadratic if this is absent", &B::element)
          .row({"fine", "", "false", "table: the fine body that corrects this one; false for none"},
               [](const SceneTable& table, const std::string& key, B& keys) {
                 keys.fine = read_fine(table, key);
               })
          .within(fine_rows())
          .number(
              "accuracy", "1", positive(),
              "relative error of the force, mesh and contact included, for which elements, element and fine "
              "are chosen where they are not given; of a volume mesh fine alone",
              &B::accuracy)
          .flag("uniform",
                "true: elements of one size; false: smaller ones under a pad, of a surface or phantom",
                &B::uniform)
          .standard("true for linear elements, false for quadratic ones");
  return rows;
}

// Small linear elements crease long before large ones: a state costs two to four times as much. Under a fine body its
// force is no better; without one the error is 16 instead of 25 % on the liver, 16 instead of 10 % on the ball (p50).
bool is_uniform(const BodyKeys& keys) {
  return keys.uniform.value_or(keys.element == Element::linear);
}

// Where elements are small: the place and radius of the pad [m], on the body as it is meshed, before body.length.
using Pressed = std::optional<Toward>;

double scale_of(const BodyKeys& keys, const Surface& surface) {
  return keys.length ? *keys.length / bounding_box(surface).size().maxCoeff() : 1.0;
}

Pressed before_scaling(Pressed pressed, double scale) {
  if (pressed) pressed = Toward{pressed->site / scale, pressed->radius / scale};
  return pressed;
}

TetMesh read_volume_or_surface(const SceneTable& body, const BodyKeys& keys, const fs::path& folder,
                               const Pressed& pressed, const std::optional<LowEnd>& rim,
                               std::vector<std::string>& warnings) {
  const fs::path file = folder / keys.mesh;
  if (!fs::is_regular_file(file))
    throw InputError(body.where("mesh"),
                     fmt::format("no such file '{}', expected a mesh, relative to the scene", file.string()));
  if (!is_surface_file(file)) {
    if (keys.elements)
      throw body.wrong("elements", "only with a surface (.obj .off .stl .ply .vtk) or a phantom");
    return read_mesh(file);
  }
  if (!keys.elements)
    throw InputError(body.where("elements"), "missing, expected a tetrahedron count, for mesh is a surface");
  const Surface surface = read_surface(file);
  for (const std::string& remark : surface.remarks) warnings.push_back(file.string() + ": " + remark);
  TetrahedraliseOptions options{.elements = *keys.elements, .length = {}, .name = file.string()};
  if (pressed && !is_uniform(keys)) {
    options.toward = before_scaling(pressed, scale_of(keys, surface));
    options.rim = rim;
  }
  return tetrahedralise(surface, options);
}

TetMesh make_phantom(const SceneTable& body, const BodyKeys& keys, Pressed pressed,
                     const std::optional<LowEnd>& rim) {
  chosen_word(body, "phantom", keys.phantom, phantom_names());
  if (pressed && !is_uniform(keys)) {
    const double scale = scale_of(keys, phantom_surface(keys.phantom));
    pressed = before_scaling(pressed, scale);
    return cached_phantom(
        {.name = keys.phantom, .elements = keys.elements.value_or(0), .toward = pressed, .rim = rim});
  }
  return cached_phantom({.name = keys.phantom, .elements = keys.elements.value_or(0)});
}

// An error about a whole section is reported at the key that gave it.
InputError at_key(const InputError& error, const BodySections& sections, const std::string& file) {
  const std::string& problem = error.problem();
  const InputPlace& place = error.place();
  const auto key_of = [](const SceneTable& table, const std::vector<std::string>& keys) {
    for (const std::string& key : keys)
      if (table.has(key)) return table.where(key);
    return table.place();
  };
  if (place.file == file && place.key == "clamp")
    return {key_of(sections.clamp, clamp_rows().alternatives()), problem};
  if (place.file == file && place.key == "contact")
    return {key_of(sections.contact, contact_rows().alternatives()), problem};
  if (place.key == "phantom") return {key_of(sections.body, {"elements", "phantom"}), problem};
  return error;
}

// The ball of the pad, before there is a mesh. tip: of a phantom, at its own size.
Pressed pressed_of(const BodySections& sections, const BodyKeys& keys, bool is_phantom) {
  const SceneTable& contact = sections.contact;
  if (!contact.has("pad") || is_anywhere(contact)) return {};
  const std::optional<Vec3> place = contact.vector("nearest");
  if (!place && !is_phantom) return {};  // read_pad() says what is missing
  const double radius = contact.number("radius", positive()).value_or(Pad().radius);
  if (place) return Toward{*place, radius};
  chosen_word(sections.body, "phantom", keys.phantom, phantom_names());
  return Toward{scale_of(keys, phantom_surface(keys.phantom)) * phantom_tip(keys.phantom), radius};
}

struct BodyInput {  // owns what it names: a finer body is made later
  BodySections sections;
  fs::path folder;
  std::string file;
  bool is_phantom = false;
  std::vector<MaterialTable> materials;
  BodyKeys keys;
};

// Mesh, regions, clamp and contact as the keys say.
Body assemble(const BodyInput& in, const BodyKeys& keys, std::vector<std::string>& warnings) {
  Body body;
  body.element = keys.element;
  const Pressed pressed = pressed_of(in.sections, keys, in.is_phantom);
  const std::optional<LowEnd> rim = rim_of(in.sections.clamp);
  body.mesh = in.is_phantom
                  ? make_phantom(in.sections.body, keys, pressed, rim)
                  : read_volume_or_surface(in.sections.body, keys, in.folder, pressed, rim, warnings);
  const std::string mesh_where =
      in.is_phantom ? in.file + ": body.phantom" : (in.folder / keys.mesh).string();
  for (const std::string& warning : check_and_orient(body.mesh, mesh_where).warnings)
    warnings.push_back(mesh_where + ": " + warning);
  if (!body.mesh.second_order.middle_nodes.empty() && !in.sections.body.has("element")) {
    body.element = Element::quadratic;
    warnings.push_back(mesh_where +
                       ": second-order tetrahedra make a quadratic body; body.element = \"linear\" takes "
                       "their corners alone");
  }
  const double scale = keys.length ? *keys.length / longest_side(body.mesh) : 1.0;
  if (keys.length) scale_to_length(body.mesh, *keys.length);
  if (const std::string size = unlikely_size(bounding_box(body.mesh)); !keys.length && !size.empty())
    warnings.push_back(mesh_where + ": " + size + "; body.length scales it");
  assign_materials(in.materials, body, warnings);
  body.clamp = read_clamp(in.sections.clamp, body.mesh, in.is_phantom);
  body.pad = read_pad(in.sections.contact, body.mesh,
                      in.is_phantom ? std::optional<Vec3>(scale * phantom_tip(keys.phantom)) : std::nullopt);
  if (is_anywhere(in.sections.contact))
    body.pad->site = free_site(body, in.sections.contact.where("anywhere"));
  if (!body.pad) body.contact = read_contact(in.sections.contact, body.mesh, in.is_phantom);
  for (const std::string& warning : check(body, in.file)) warnings.push_back(in.file + ": " + warning);
  return body;
}

// Numbers of nodes belong to one mesh. key: what makes another; without: the scene that makes none.
void refuse_numbers(const BodyInput& in, const std::string& key, const std::string& without) {
  for (const auto& [table, numbers] :
       {std::pair(&in.sections.clamp, "nodes"), std::pair(&in.sections.contact, "nodes"),
        std::pair(&in.sections.contact, "node")})
    if (table->has(numbers))
      throw InputError(
          table->where(numbers),
          "numbers nodes of one mesh, so " + key +
              " cannot find them in another; expected a group, a place or a part of the body, or " + without);
}

bool subdivides(const BodyInput& in) {
  return !in.is_phantom && !is_surface_file(in.folder / in.keys.mesh);
}

// A fine body: a phantom or a surface is meshed again, a volume mesh is subdivided.
Body assemble_fine(const BodyInput& in, const Body& body, std::size_t elements) {
  BodyKeys keys = in.keys;
  keys.element = in.keys.fine->element;
  keys.fine.reset();
  if (subdivides(in)) {
    Body fine = refined_to(body, elements);
    fine.element = keys.element;
    return fine;
  }
  keys.elements = elements;
  refuse_numbers(in, "body.fine", "body.fine = false");
  std::vector<std::string> said;  // of the same file, already
  Body fine = assemble(in, keys, said);
  if (body.pad) {
    fine.pad = body.pad;
    fine.pad->site = nearest_site(fine.mesh, body.pad->site);
  }
  return fine;
}

FineBodies assemble_fine(const BodyInput& in, const Body& body) {
  FineBodies fine;
  try {
    fine.first = assemble_fine(in, body, in.keys.fine->elements);
  } catch (const InputError& error) {
    if (error.place().key != "phantom") throw;
    throw InputError(in.sections.body.where("fine"), error.problem());
  }
  fine.make = [in, body](std::size_t elements) { return assemble_fine(in, body, elements); };
  fine.subdivided = subdivides(in);
  return fine;
}

// The body with its fine body, if it has one.
Body complete(const BodyInput& in, bool quiet, std::vector<std::string>& warnings) {
  Body body = assemble(in, in.keys, warnings);
  if (in.keys.fine)
    body.fine = fine_jet_of(body, assemble_fine(in, body), in.sections.body.where("fine"), quiet);
  return body;
}

BodyKeys of_trial(BodyKeys keys, const AccuracyTrial& trial) {
  keys.element = trial.element;
  if (trial.elements > 0) keys.elements = trial.elements;
  if (trial.fine == 0) keys.fine.reset();
  if (trial.fine != 0 && !keys.fine) keys.fine = FineKeys{.elements = trial.fine};
  return keys;
}

AccuracyChoice accurate(const BodyInput& in, bool quiet) {
  AccuracyGiven given{.element = {}, .elements = in.keys.elements, .fine = {}};
  const bool mesh_given = subdivides(in);
  if (mesh_given)
    given.mesh_tets = read_mesh(in.folder / in.keys.mesh).tets.size();
  else
    refuse_numbers(in, "body.accuracy", "no body.accuracy");
  if (mesh_given || in.sections.body.has("element")) given.element = in.keys.element;
  if (in.sections.body.has("fine")) given.fine = in.keys.fine ? in.keys.fine->elements : 0;
  if (mesh_given && given.fine)
    throw in.sections.body.wrong("accuracy",
                                 "no body.fine beside it: of a volume mesh there is nothing else to choose");
  std::ostringstream about(in.sections.text, std::ios::ate);
  if (!in.is_phantom) about << std::ifstream(in.folder / in.keys.mesh, std::ios::binary).rdbuf();
  Globals globals;
  globals.quiet = quiet;
  Progress progress(globals, "body.accuracy");
  const auto make = [&](const AccuracyTrial& trial) {
    progress.show(in_words(trial));
    std::vector<std::string> said;
    BodyInput tried = in;
    tried.keys = of_trial(in.keys, trial);
    return complete(tried, true, said);
  };
  return choose_accuracy(*in.keys.accuracy, accuracy_trials(given), about.str(), {make, inward_direction});
}

BodyRead make_body(const BodySections& sections, const fs::path& folder, const std::string& file, bool quiet,
                   std::vector<std::string>& warnings) {
  BodyInput in{sections, folder, file, false, {}, {}};
  in.is_phantom = sections.body.exactly_one_of(body_rows().alternatives()) == "phantom";
  in.materials = read_materials(sections.materials, in.is_phantom);  // cheap checks before the mesh is made
  rows_of_body().read(sections.body, in.keys);
  const bool anywhere = is_anywhere(sections.contact);
  if (anywhere && in.keys.accuracy)
    throw InputError(sections.body.where("accuracy"),
                     "is for a contact with one place, expected none with contact.anywhere");
  BodyRead read;
  if (in.keys.accuracy) {
    read.accuracy = accurate(in, quiet);
    in.keys = of_trial(in.keys, read.accuracy->taken);
    if (!read.accuracy->reached)
      warnings.push_back(sections.body.where("accuracy").text() + ": " + in_words(*read.accuracy));
  }
  if (!anywhere) {
    read.body = complete(in, quiet, warnings);
    return read;
  }
  read.body = assemble(in, in.keys, warnings);
  if (in.keys.fine) read.fine = std::make_shared<const FineBodies>(assemble_fine(in, read.body));
  return read;
}

}  // namespace

const SceneRowList& body_rows() {
  return rows_of_body();
}
BodyRead read_body(const BodySections& sections, const fs::path& folder, const std::string& file, bool quiet,
                   std::vector<std::string>& warnings) {
  try {
    return make_body(sections, folder, file, quiet, warnings);
  } catch (const InputError& error) {
    throw at_key(error, sections, file);
  }
}

Vec3 inward_direction(const Body& body) {
  if (body.pad) {
    const Vec3 normal = pad_surface(body.mesh, *body.pad).normal;
    return normal.isZero() ? Vec3(-Vec3::UnitZ()) : Vec3(-normal);
  }
  const auto touched = [&](NodeIndex node) { return std::ranges::binary_search(body.contact, node) ? 1 : 0; };
  Vec3 patch = Vec3::Zero(), around = Vec3::Zero();
  for (const Triangle& triangle : boundary_triangles(body.mesh)) {
    const auto corner = [&](std::size_t i) -> const Vec3& { return body.mesh.nodes[triangle[i]]; };
    const Vec3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    const int corners = touched(triangle[0]) + touched(triangle[1]) + touched(triangle[2]);
    if (corners == 3) patch += normal;
    if (corners > 0) around += normal;
  }
  const Vec3 outward = patch.norm() > 0 ? patch : around;
  return outward.norm() > 0 ? Vec3(-outward.normalized()) : Vec3(-Vec3::UnitZ());
}

Box default_box(const TetMesh& mesh, double spacing) {
  const Vec3 size = bounding_box(mesh).size();
  Vec3 half;
  for (int axis = 0; axis < 3; ++axis)
    half[axis] =
        spacing * std::max(1.0, std::floor(std::min(size.maxCoeff() / 6, 0.4 * size[axis]) / spacing + 1e-9));
  return {-half, half};
}

}  // namespace forefeel
