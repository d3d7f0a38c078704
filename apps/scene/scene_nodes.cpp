#include "apps/scene/scene_nodes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/scene/scene_declared.hpp"
#include "scheduling/touch/surface_models.hpp"
#include "solver/body/pad.hpp"
#include "solver/jet/site_field.hpp"

namespace forefeel {
namespace {

// What the keys of [clamp] or [contact] choose.
struct NodeSet {
  const TetMesh* mesh = nullptr;
  std::vector<NodeIndex> nodes;
  std::optional<double> radius;  // [m], of contact
  std::optional<double> pad;     // [N/m], of contact
  std::optional<Vec3> place;     // of `nearest`, as given [m]
  bool anywhere = false;         // of contact
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
          .standard("none: a rigid patch")
          .flag("anywhere",
                "true: the pad is put at any place of the surface, in place of nearest; see solve --site",
                &NodeSet::anywhere)
          .row({"friction", "1", "",
                "with anywhere: coefficient of friction, at least 0, of tip and surface; the tip slides "
                "beyond it"})
          .standard(fmt::format("{}, that of moist tissue", usual_friction))
          .row({"bonded", "bool", "",
                "with anywhere, in place of friction: true: the tip sticks where it came in, and "
                "drags that place along"})
          .standard("false")
          .row({"site_spacing", "m", "",
                "with anywhere: distance of the sites whose jets at rest make the field of forces"})
          .standard(fmt::format("{}", SiteFieldOptions().spacing));
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

}  // namespace

const SceneRowList& clamp_rows() {
  return rows_of_clamp();
}
const SceneRowList& contact_rows() {
  return rows_of_contact();
}

std::vector<NodeIndex> read_clamp(const SceneTable& clamp, const TetMesh& mesh, bool is_phantom) {
  return read_nodes(clamp, rows_of_clamp(), mesh, is_phantom ? "clamp" : nullptr);
}

std::vector<NodeIndex> read_contact(const SceneTable& contact, const TetMesh& mesh, bool is_phantom) {
  return read_nodes(contact, rows_of_contact(), mesh, is_phantom ? "contact" : nullptr);
}

std::optional<LowEnd> rim_of(const SceneTable& clamp) {
  if (!clamp.has("below")) return {};
  BelowKeys keys;
  const SceneTable below = clamp.sub("below", below_rows().names());
  below_rows().read(below, keys);
  below_rows().check_required(below);
  return LowEnd{keys.axis, keys.share};
}

bool is_anywhere(const SceneTable& contact) {
  return contact.boolean("anywhere").value_or(false);
}

std::optional<Pad> read_pad(const SceneTable& table, const TetMesh& mesh, const std::optional<Vec3>& tip) {
  const bool anywhere = is_anywhere(table);
  if (!table.has("pad")) {
    if (anywhere)
      throw InputError(table.where("pad"), "missing, expected a stiffness [N/m] beside anywhere = true");
    return {};
  }
  for (const char* key : {"node", "nodes", "group"})
    if (table.has(key)) throw table.wrong(key, "no nodes beside pad: its place is nearest = [x, y, z]");
  NodeSet set;
  set.mesh = &mesh;
  rows_of_contact().read(table, set);
  if (!set.place && !tip && !anywhere)
    throw InputError(table.where("nearest"),
                     "missing, expected [x, y, z], the place of the pad on the mesh [m]");
  Pad pad;
  if (!anywhere) pad.site = nearest_site(mesh, set.place ? *set.place : *tip);
  pad.radius = set.radius.value_or(pad.radius);
  pad.stiffness = *set.pad;
  return pad;
}

}  // namespace forefeel
