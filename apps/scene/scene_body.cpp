#include "apps/scene/scene_body.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "apps/scene/phantom_cache.hpp"
#include "apps/scene/scene_declared.hpp"
#include "apps/scene/scene_fine.hpp"
#include "apps/scene/scene_materials.hpp"
#include "geometry/mesh/length_unit.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/phantom.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t most_elements = 10'000'000;

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
          .whole("elements", 4, most_elements,
                 "its tetrahedra; a volume mesh is subdivided until it has as many", &F::elements)
          .word("element", element_words, " tetrahedra", &F::element);
  return rows;
}

// { elements, element } or false.
std::optional<FineKeys> read_fine(const SceneTable& body, const std::string& key) {
  if (!body.holds_table(key)) {
    if (*body.boolean(key)) throw body.wrong(key, "false or a table { elements = N }");
    return {};
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
  bool uniform = false;
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
          .word("element", element_words, " tetrahedra", &B::element)
          .row({"fine", "", "false", "table: the fine body that corrects this one; false for none"},
               [](const SceneTable& table, const std::string& key, B& keys) {
                 keys.fine = read_fine(table, key);
               })
          .within(fine_rows())
          .flag("uniform",
                "a surface or phantom with a pad is meshed with elements of one size, not smaller ones under "
                "the pad",
                &B::uniform);
  return rows;
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
                               const Pressed& pressed, const std::optional<LowEnd>& rim) {
  const fs::path file = folder / keys.mesh;
  if (!fs::is_regular_file(file))
    throw InputError(body.where("mesh"),
                     fmt::format("no such file '{}', expected a mesh, relative to the scene", file.string()));
  if (!is_surface_file(file)) {
    if (keys.elements)
      throw body.wrong("elements", "only with a surface (.obj .off .stl .ply .vtp) or a phantom");
    return read_mesh(file);
  }
  if (!keys.elements)
    throw InputError(body.where("elements"), "missing, expected a tetrahedron count, for mesh is a surface");
  const Surface surface = read_surface(file);
  TetrahedraliseOptions options{.elements = *keys.elements, .length = {}, .name = file.string()};
  if (pressed && !keys.uniform) {
    options.toward = before_scaling(pressed, scale_of(keys, surface));
    options.rim = rim;
  }
  return tetrahedralise(surface, options);
}

TetMesh make_phantom(const SceneTable& body, const BodyKeys& keys, Pressed pressed,
                     const std::optional<LowEnd>& rim) {
  chosen_word(body, "phantom", keys.phantom, phantom_names());
  if (pressed && !keys.uniform) {
    const double scale = scale_of(keys, phantom_surface(keys.phantom));
    pressed = before_scaling(pressed, scale);
    return cached_phantom(
        {.name = keys.phantom, .elements = keys.elements.value_or(0), .toward = pressed, .rim = rim});
  }
  return cached_phantom({.name = keys.phantom, .elements = keys.elements.value_or(0)});
}

// ---- sets of nodes

// What the keys of [clamp] or [contact] choose.
struct NodeSet {
  const TetMesh* mesh = nullptr;
  std::vector<NodeIndex> nodes;
  std::optional<double> radius;  // [m], of contact
  std::optional<double> pad;     // [N/m], of contact
  std::optional<Vec3> place;     // of `nearest`, as given [m]
};
using Choose = std::vector<NodeIndex> (*)(const SceneTable&, const std::string& key, const TetMesh&);

SceneRows<NodeSet>::Reader by(Choose choose) {
  return [choose](const SceneTable& table, const std::string& key, NodeSet& set) {
    set.nodes = choose(table, key, *set.mesh);
  };
}

std::vector<NodeIndex> nodes_in_group(const SceneTable& table, const std::string& key, const TetMesh& mesh) {
  std::vector<std::string> names;
  for (const auto& [group, nodes] : mesh.groups) names.push_back(group);
  const std::string wanted = *table.text(key);
  if (names.empty())
    throw InputError(table.where(key), fmt::format("'{}', but the mesh names no node groups", wanted));
  const std::vector<NodeIndex>& nodes = mesh.groups.at(names[chosen_word(table, key, wanted, names)]);
  if (nodes.empty()) throw table.wrong(key, "a group with nodes in it");
  return nodes;
}

std::vector<NodeIndex> checked_nodes(const SceneTable& table, const std::string& key,
                                     const std::vector<std::int64_t>& numbers, const TetMesh& mesh) {
  std::vector<NodeIndex> nodes;
  for (const std::int64_t number : numbers) {
    if (number < 0 || number >= static_cast<std::int64_t>(mesh.nodes.size()))
      throw InputError(table.where(key), fmt::format("node {} is out of range, expected 0 to {}", number,
                                                     mesh.nodes.size() - 1));
    nodes.push_back(static_cast<NodeIndex>(number));
  }
  std::ranges::sort(nodes);
  if (const auto twice = std::ranges::adjacent_find(nodes); twice != nodes.end())
    throw InputError(table.where(key), fmt::format("names node {} twice, expected each node once", *twice));
  return nodes;
}

std::vector<NodeIndex> one_node(const SceneTable& table, const std::string& key, const TetMesh& mesh) {
  return checked_nodes(table, key, {*table.integer(key, INT64_MIN, INT64_MAX)}, mesh);
}

std::vector<NodeIndex> numbered_nodes(const SceneTable& table, const std::string& key, const TetMesh& mesh) {
  return checked_nodes(table, key, *table.integers(key), mesh);
}

struct BelowKeys {
  Axis axis = Axis::x;
  double share = 0;
};

const SceneRows<BelowKeys>& below_rows() {
  using B = BelowKeys;
  static const auto rows =
      SceneRows<B>("clamp.below",
                   "The part of the body that is clamped: clamp.below = { axis = \"z\", share = 0.15 }")
          .word("axis", axis_words, "", &B::axis)
          .required("one of x, y, z")
          .number("share", "1", {0, 1, true, true, "a number between 0 and 1"},
                  "of the body's extent along the axis, between 0 and 1", &B::share)
          .required("a number between 0 and 1");
  return rows;
}

std::vector<NodeIndex> low_end(const SceneTable& table, const std::string& key, const TetMesh& mesh) {
  const SceneTable below = table.sub(key, below_rows().names());
  BelowKeys keys;
  below_rows().read(below, keys);
  below_rows().check_required(below);
  const std::vector<NodeIndex> nodes = nodes_below(mesh, keys.axis, keys.share);
  if (nodes.empty()) throw InputError(table.where(key), "holds no node, expected a larger share");
  return nodes;
}

// A place far outside the body is a slip, such as millimetres for metres.
Vec3 checked_place(const SceneTable& table, const std::string& key, const TetMesh& mesh) {
  constexpr double far = 100;  // times the longest side of the body
  const Vec3 place = *table.vector(key);
  const Box box = bounding_box(mesh);
  const double most = far * box.size().maxCoeff();
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.low[axis], high = box.high[axis];
    if (place[axis] >= low - most && place[axis] <= high + most) continue;
    throw InputError(table.where(key),
                     fmt::format("has {} = {:g} m, far from the body, expected about {:.3g} to {:.3g}",
                                 "xyz"[axis], place[axis], low, high));
  }
  return place;
}

void nearest_node(const SceneTable& table, const std::string& key, NodeSet& set) {
  set.place = checked_place(table, key, *set.mesh);
  set.nodes = {nearest_surface_node(*set.mesh, *set.place)};
}

const SceneRows<NodeSet>& rows_of_clamp() {
  static const auto rows =
      SceneRows<NodeSet>("clamp", "The nodes that do not move. One of nodes, group and below.")
          .row({"nodes", "", "", "node numbers from 0, in the order of the file"}, by(numbered_nodes))
          .alternative()
          .row({"group", "", "clamp, with a phantom", "name of a node group of the mesh"}, by(nodes_in_group))
          .alternative()
          .row({"below", "", "", "table: the part of the body at the low end of an axis"}, by(low_end))
          .alternative()
          .within(below_rows());
  return rows;
}

const SceneRows<NodeSet>& rows_of_contact() {
  static const auto rows =
      SceneRows<NodeSet>(
          "contact",
          "The patch that moves with the tip: one of node, nodes, nearest and group; or, with pad, "
          "springs around the place nearest.")
          .row({"node", "", "", "a node number, from 0"}, by(one_node))
          .alternative()
          .row({"nodes", "", "", "node numbers, from 0"}, by(numbered_nodes))
          .alternative()
          .row({"nearest", "m", "",
                "[x, y, z]: the surface node nearest to this place of the mesh; with pad the point of the "
                "surface, "
                "on a phantom its tip if absent"},
               nearest_node)
          .alternative()
          .row({"group", "", "contact, with a phantom", "name of a node group of the mesh"},
               by(nodes_in_group))
          .alternative()
          .number("radius", "m", positive(),
                  "also all surface nodes within this distance of them; with pad the radius of its springs",
                  &NodeSet::radius)
          .standard("only the nodes named; with pad 0.02 m")
          .number(
              "pad", "N/m", positive(),
              "stiffness of a compliant pad, about a fingertip's: springs between surface and tip instead of "
              "nodes that move with it",
              &NodeSet::pad)
          .standard("none: a rigid patch");
  return rows;
}

// default_group: of a phantom, where the table is empty.
std::vector<NodeIndex> read_nodes(const SceneTable& table, const SceneRows<NodeSet>& rows,
                                  const TetMesh& mesh, const char* default_group) {
  const std::vector<std::string> keys = rows.names();
  if (default_group && std::ranges::none_of(keys, [&](const std::string& key) { return table.has(key); }))
    return mesh.groups.at(default_group);
  const std::vector<std::string> ways = rows.alternatives();
  const bool named = std::ranges::any_of(ways, [&](const std::string& key) { return table.has(key); });
  if (named) table.exactly_one_of(ways);
  NodeSet set;
  set.mesh = &mesh;
  rows.read(table, set);
  if (!named) table.exactly_one_of(ways);  // after what is wrong with other keys
  if (!set.radius) return set.nodes;
  std::vector<NodeIndex> patch = set.nodes;
  for (const NodeIndex node : set.nodes) {
    const std::vector<NodeIndex> near = surface_nodes_within(mesh, mesh.nodes[node], *set.radius);
    patch.insert(patch.end(), near.begin(), near.end());
  }
  std::ranges::sort(patch);
  patch.erase(std::unique(patch.begin(), patch.end()), patch.end());
  return patch;
}

// The pad of [contact]; nullopt without the key `pad`. tip: of a phantom.
std::optional<Pad> read_pad(const SceneTable& table, const TetMesh& mesh, const std::optional<Vec3>& tip) {
  if (!table.has("pad")) return {};
  for (const char* key : {"node", "nodes", "group"})
    if (table.has(key)) throw table.wrong(key, "no nodes beside pad: its place is nearest = [x, y, z]");
  NodeSet set;
  set.mesh = &mesh;
  rows_of_contact().read(table, set);
  if (!set.place && !tip)
    throw InputError(table.where("nearest"),
                     "missing, expected [x, y, z], the place of the pad on the mesh [m]");
  Pad pad{.site = nearest_site(mesh, set.place ? *set.place : *tip)};
  pad.radius = set.radius.value_or(pad.radius);
  pad.stiffness = *set.pad;
  return pad;
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
  if (!contact.has("pad")) return {};
  const std::optional<Vec3> place = contact.vector("nearest");
  if (!place && !is_phantom) return {};  // read_pad() says what is missing
  const double radius = contact.number("radius", positive()).value_or(Pad().radius);
  if (place) return Toward{*place, radius};
  chosen_word(sections.body, "phantom", keys.phantom, phantom_names());
  return Toward{scale_of(keys, phantom_surface(keys.phantom)) * phantom_tip(keys.phantom), radius};
}

// The clamp, where it is a low end of the body: its rim becomes edges of a graded mesh.
std::optional<LowEnd> rim_of(const SceneTable& clamp) {
  if (!clamp.has("below")) return {};
  BelowKeys keys;
  const SceneTable below = clamp.sub("below", below_rows().names());
  below_rows().read(below, keys);
  below_rows().check_required(below);
  return LowEnd{keys.axis, keys.share};
}

struct BodyInput {
  const BodySections& sections;
  const fs::path& folder;
  const std::string& file;
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
  body.mesh = in.is_phantom ? make_phantom(in.sections.body, keys, pressed, rim)
                            : read_volume_or_surface(in.sections.body, keys, in.folder, pressed, rim);
  const std::string mesh_where =
      in.is_phantom ? in.file + ": body.phantom" : (in.folder / keys.mesh).string();
  const MeshCheck mesh_check = check_and_orient(body.mesh, mesh_where);
  for (const std::string& warning : mesh_check.warnings) warnings.push_back(mesh_where + ": " + warning);
  const double scale = keys.length ? *keys.length / longest_side(body.mesh) : 1.0;
  if (keys.length) scale_to_length(body.mesh, *keys.length);
  if (const std::string size = unlikely_size(bounding_box(body.mesh)); !keys.length && !size.empty())
    warnings.push_back(mesh_where + ": " + size + "; body.length scales it");
  assign_materials(in.materials, body, warnings);
  body.clamp = read_nodes(in.sections.clamp, rows_of_clamp(), body.mesh, in.is_phantom ? "clamp" : nullptr);
  body.pad = read_pad(in.sections.contact, body.mesh,
                      in.is_phantom ? std::optional<Vec3>(scale * phantom_tip(keys.phantom)) : std::nullopt);
  if (!body.pad)
    body.contact =
        read_nodes(in.sections.contact, rows_of_contact(), body.mesh, in.is_phantom ? "contact" : nullptr);
  for (const std::string& warning : check(body, in.file)) warnings.push_back(in.file + ": " + warning);
  return body;
}

// A fine body: a phantom or a surface is meshed again, a volume mesh is subdivided. Numbers of nodes belong to one mesh,
// so they cannot be carried to another.
Body assemble_fine(const BodyInput& in, const Body& body, std::size_t elements) {
  BodyKeys keys = in.keys;
  keys.element = in.keys.fine->element;
  const bool meshed = in.is_phantom || is_surface_file(in.folder / keys.mesh);
  if (!meshed) {
    Body fine = refined_to(body, elements);
    fine.element = keys.element;
    return fine;
  }
  keys.elements = elements;
  for (const auto& [table, key] :
       {std::pair(&in.sections.clamp, "nodes"), std::pair(&in.sections.contact, "nodes"),
        std::pair(&in.sections.contact, "node")})
    if (table->has(key))
      throw InputError(
          table->where(key),
          "numbers nodes of one mesh, so body.fine cannot find them in another; expected a group, a "
          "place or a part of the body, or body.fine = false");
  std::vector<std::string> said;  // of the same file, already
  Body fine = assemble(in, keys, said);
  if (body.pad) {
    fine.pad = body.pad;
    fine.pad->site = nearest_site(fine.mesh, body.pad->site);
  }
  return fine;
}

// The second has a quarter of the first one's tetrahedra, or the subdivision before.
FineBodies assemble_fine(const BodyInput& in, const Body& body) {
  Body first = assemble_fine(in, body, in.keys.fine->elements);
  const std::size_t made = first.mesh.tets.size();
  return {std::move(first), assemble_fine(in, body, std::max<std::size_t>(4, made / 8))};
}

Body make_body(const BodySections& sections, const fs::path& folder, const std::string& file, bool quiet,
               std::vector<std::string>& warnings) {
  BodyInput in{sections, folder, file, false, {}, {}};
  in.is_phantom = sections.body.exactly_one_of(body_rows().alternatives()) == "phantom";
  in.materials =
      read_materials(sections.materials, in.is_phantom);  // cheap checks first, before the mesh is made
  rows_of_body().read(sections.body, in.keys);
  Body body = assemble(in, in.keys, warnings);
  if (in.keys.fine)
    body.fine = fine_jet_of(body, assemble_fine(in, body), sections.body.where("fine"), quiet);
  return body;
}

}  // namespace

const SceneRowList& body_rows() {
  return rows_of_body();
}
const SceneRowList& clamp_rows() {
  return rows_of_clamp();
}
const SceneRowList& contact_rows() {
  return rows_of_contact();
}

Body read_body(const BodySections& sections, const fs::path& folder, const std::string& file, bool quiet,
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
