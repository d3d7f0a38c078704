#include "apps/scene/scene_body.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "apps/console/suggest.hpp"
#include "apps/scene/phantom_cache.hpp"
#include "apps/scene/scene_declared.hpp"
#include "apps/scene/scene_materials.hpp"
#include "geometry/mesh/length_unit.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/phantom.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t most_elements = 10'000'000;

TetMesh read_volume_or_surface(const SceneTable& body, const fs::path& folder) {
  const fs::path file = folder / *body.text("mesh");
  if (!fs::is_regular_file(file))
    throw InputError(body.where("mesh"),
                     fmt::format("no such file '{}', expected a mesh, relative to the scene", file.string()));
  const auto elements = body.integer("elements", 4, most_elements);
  if (!is_surface_file(file)) {
    if (elements) throw body.wrong("elements", "only with a surface (.obj .off .stl .ply .vtp) or a phantom");
    return read_mesh(file);
  }
  if (!elements)
    throw InputError(body.where("elements"), "missing, expected a tetrahedron count, for mesh is a surface");
  return tetrahedralise(
      read_surface(file),
      {.elements = static_cast<std::size_t>(*elements), .length = {}, .name = file.string()});
}

TetMesh make_phantom(const SceneTable& body) {
  const std::vector<std::string> names = phantom_names();
  const std::string name = names[chosen_word(body, "phantom", *body.text("phantom"), names)];
  return cached_phantom(name,
                        static_cast<std::size_t>(body.integer("elements", 4, most_elements).value_or(0)));
}

std::vector<NodeIndex> group_nodes(const SceneTable& table, const TetMesh& mesh) {
  std::vector<std::string> names;
  for (const auto& [group, nodes] : mesh.groups) names.push_back(group);
  const std::string wanted = *table.text("group");
  if (names.empty())
    throw InputError(table.where("group"), fmt::format("'{}', but the mesh names no node groups", wanted));
  const std::vector<NodeIndex>& nodes = mesh.groups.at(names[chosen_word(table, "group", wanted, names)]);
  if (nodes.empty()) throw table.wrong("group", "a group with nodes in it");
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

std::vector<NodeIndex> read_clamp(const SceneTable& table, const TetMesh& mesh, bool defaults) {
  if (defaults && !table.has("nodes") && !table.has("group") && !table.has("below"))
    return mesh.groups.at("clamp");
  const std::string kind = table.exactly_one_of({"nodes", "group", "below"});
  if (kind == "nodes") return checked_nodes(table, "nodes", *table.integers("nodes"), mesh);
  if (kind == "group") return group_nodes(table, mesh);
  const SceneTable below = table.sub("below", keys_of("clamp.below"));
  const std::optional<Axis> axis = below.word<Axis>("axis", {{"x", Axis::x}, {"y", Axis::y}, {"z", Axis::z}});
  const std::optional<double> part = below.number("share", {0, 1, true, true, "a number between 0 and 1"});
  if (!axis) throw below.wrong("axis", "one of x, y, z");
  if (!part) throw below.wrong("share", "a number between 0 and 1");
  const std::vector<NodeIndex> nodes = nodes_below(mesh, *axis, *part);
  if (nodes.empty()) throw InputError(table.where("below"), "holds no node, expected a larger share");
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

std::vector<NodeIndex> read_contact(const SceneTable& table, const TetMesh& mesh, bool defaults) {
  const std::optional<double> radius = table.number("radius", positive());
  const bool any = table.has("node") || table.has("nodes") || table.has("nearest") || table.has("group");
  std::vector<NodeIndex> nodes;
  if (defaults && !any && !radius) return mesh.groups.at("contact");
  const std::string kind = table.exactly_one_of({"node", "nodes", "nearest", "group"});
  if (kind == "node")
    nodes = checked_nodes(table, "node", {*table.integer("node", INT64_MIN, INT64_MAX)}, mesh);
  if (kind == "nodes") nodes = checked_nodes(table, "nodes", *table.integers("nodes"), mesh);
  if (kind == "group") nodes = group_nodes(table, mesh);
  if (kind == "nearest") nodes = {nearest_surface_node(mesh, checked_place(table, "nearest", mesh))};
  if (!radius) return nodes;
  std::vector<NodeIndex> patch = nodes;
  for (const NodeIndex node : nodes) {
    const std::vector<NodeIndex> near = surface_nodes_within(mesh, mesh.nodes[node], *radius);
    patch.insert(patch.end(), near.begin(), near.end());
  }
  std::ranges::sort(patch);
  patch.erase(std::unique(patch.begin(), patch.end()), patch.end());
  return patch;
}

// An error about a whole section is reported at the key that gave it.
InputError at_key(const InputError& error, const BodySections& sections, const std::string& file) {
  const std::string& problem = error.problem();
  const InputPlace& place = error.place();
  const auto key_of = [](const SceneTable& table, std::initializer_list<const char*> keys) {
    for (const char* key : keys)
      if (table.has(key)) return table.where(key);
    return table.place();
  };
  if (place.file == file && place.key == "clamp")
    return {key_of(sections.clamp, {"nodes", "group", "below"}), problem};
  if (place.file == file && place.key == "contact")
    return {key_of(sections.contact, {"node", "nodes", "nearest", "group"}), problem};
  if (place.key == "phantom") return {key_of(sections.body, {"elements", "phantom"}), problem};
  return error;
}

constexpr double shortest = 1e-6,
                 longest = 1e6;  // bodies [m]; beyond them sums of squares over- or underflow

Body make_body(const BodySections& sections, const fs::path& folder, const std::string& file,
               std::vector<std::string>& warnings) {
  const bool is_phantom = sections.body.exactly_one_of({"mesh", "phantom"}) == "phantom";
  Body body;
  const std::vector<MaterialTable> materials =
      read_materials(sections.materials, is_phantom);  // cheap checks first, before the mesh is made
  const std::optional<double> length = sections.body.number(
      "length", {shortest, longest, false, false, "a number above 0, from 1e-6 to 1e6 [m]"});
  body.element =
      sections.body.word<Element>("element", {{"linear", Element::linear}, {"quadratic", Element::quadratic}})
          .value_or(body.element);
  body.mesh = is_phantom ? make_phantom(sections.body) : read_volume_or_surface(sections.body, folder);
  const std::string mesh_where =
      is_phantom ? file + ": body.phantom" : (folder / *sections.body.text("mesh")).string();
  const MeshCheck mesh_check = check_and_orient(body.mesh, mesh_where);
  for (const std::string& warning : mesh_check.warnings) warnings.push_back(mesh_where + ": " + warning);
  if (length) scale_to_length(body.mesh, *length);
  if (const std::string size = unlikely_size(bounding_box(body.mesh)); !length && !size.empty())
    warnings.push_back(mesh_where + ": " + size + "; body.length scales it");
  assign_materials(materials, body, warnings);
  body.clamp = read_clamp(sections.clamp, body.mesh, is_phantom);
  body.contact = read_contact(sections.contact, body.mesh, is_phantom);
  for (const std::string& warning : check(body, file)) warnings.push_back(file + ": " + warning);
  return body;
}

}  // namespace

Body read_body(const BodySections& sections, const fs::path& folder, const std::string& file,
               std::vector<std::string>& warnings) {
  try {
    return make_body(sections, folder, file, warnings);
  } catch (const InputError& error) {
    throw at_key(error, sections, file);
  }
}

Vec3 inward_direction(const Body& body) {
  const auto touched = [&](NodeIndex node) { return std::ranges::binary_search(body.contact, node) ? 1 : 0; };
  Vec3 patch = Vec3::Zero(), around = Vec3::Zero();
  for (const Triangle& triangle : boundary_triangles(body.mesh)) {
    const auto corner = [&](int i) -> const Vec3& {
      return body.mesh.nodes[static_cast<std::size_t>(triangle[static_cast<std::size_t>(i)])];
    };
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
