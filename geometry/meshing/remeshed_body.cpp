#include "geometry/meshing/remeshed_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "geometry/common/error.hpp"
#include "geometry/meshing/surface_process.hpp"

namespace forefeel {
namespace {

constexpr const char* advice = "a mesh of its boundary cannot keep; split its elements in eight instead";

// What of a group of nodes lies on the boundary.
struct Patch {
  std::vector<char> covers;  // by triangle of the boundary: all three nodes are in the group
  std::vector<Vec3> single;  // nodes of no such triangle
};

class Boundary {
 public:
  Boundary(const TetMesh& mesh, const std::string& name)
      : mesh_(mesh), name_(name), triangles_(boundary_triangles(mesh)), nodes_(surface_nodes(mesh)) {}

  std::size_t triangles() const { return triangles_.size(); }

  Patch patch(const std::string& group, const std::vector<NodeIndex>& members) const {
    const auto in = [&](NodeIndex node) { return std::ranges::binary_search(members, node); };
    if (!std::ranges::includes(nodes_, members))
      throw InputError(name_, fmt::format("group '{}' has nodes inside the body, which {}", group, advice));
    Patch result;
    std::set<NodeIndex> covered;
    for (const Triangle& t : triangles_) {
      result.covers.push_back(std::ranges::all_of(t, in));
      if (result.covers.back()) covered.insert(t.begin(), t.end());
    }
    const auto is_line = [&](NodeIndex a, NodeIndex b) {
      return in(a) && in(b) && (!covered.contains(a) || !covered.contains(b));
    };
    bool line = false;
    for (const Triangle& t : triangles_)
      for (std::size_t k = 0; k < 3; ++k) line = line || is_line(t[k], t[(k + 1) % 3]);
    // Nodes at the ragged border of a patch stay; a group that is mostly lines would lose its meaning.
    if (line && 2 * covered.size() < members.size())
      throw InputError(name_, fmt::format("group '{}' has nodes in a line, which {}", group, advice));
    for (const NodeIndex node : members)
      if (!covered.contains(node)) result.single.push_back(mesh_.nodes[node]);
    return result;
  }

 private:
  const TetMesh& mesh_;
  const std::string& name_;
  std::vector<Triangle> triangles_;
  std::vector<NodeIndex> nodes_;
};

void check_element_groups(const TetMesh& mesh, const std::string& name) {
  for (const auto& [group, tets] : mesh.element_groups)
    if (tets.size() != mesh.tets.size())
      throw InputError(name, fmt::format("group '{}' is a part of the body with a border inside it, which {}",
                                         group, advice));
}

NodeIndex nearest_node(const TetMesh& mesh, const Vec3& place) {
  const auto nearest = std::ranges::min_element(
      mesh.nodes, {}, [&](const Vec3& node) { return (node - place).squaredNorm(); });
  return static_cast<NodeIndex>(nearest - mesh.nodes.begin());
}

}  // namespace

TetMesh remeshed(const TetMesh& given, TetrahedraliseOptions options, TetrahedraliseReport* report) {
  TetMesh mesh = given;
  if (options.length) scale_to_length(mesh, *options.length);
  options.length.reset();
  check_element_groups(mesh, options.name);
  const Boundary boundary(mesh, options.name);
  std::map<std::string, Patch> patches;
  for (const auto& [group, nodes] : mesh.groups) patches[group] = boundary.patch(group, nodes);
  // Triangles in the same groups have one mark.
  std::map<std::vector<char>, int> known;
  options.marks.clear(), options.pins.clear();
  for (std::size_t t = 0; t < boundary.triangles(); ++t) {
    std::vector<char> of;
    for (const auto& [group, patch] : patches) of.push_back(patch.covers[t]);
    options.marks.push_back(known.emplace(of, static_cast<int>(known.size())).first->second);
  }
  for (const auto& [group, patch] : patches)
    options.pins.insert(options.pins.end(), patch.single.begin(), patch.single.end());

  const Surface before = boundary_surface(mesh);
  TetMesh result = tetrahedralise(before, options, report);
  const auto nearest = nearest_on(before);
  std::map<std::string, std::set<NodeIndex>> sets;
  for (const Triangle& t : boundary_triangles(result)) {
    const Vec3 centre = (result.nodes[t[0]] + result.nodes[t[1]] + result.nodes[t[2]]) / 3;
    const std::size_t at = nearest(centre).triangle;
    for (const auto& [group, patch] : patches)
      if (patch.covers[at]) sets[group].insert(t.begin(), t.end());
  }
  for (const auto& [group, patch] : patches) {
    for (const Vec3& place : patch.single) sets[group].insert(nearest_node(result, place));
    result.groups[group].assign(sets[group].begin(), sets[group].end());
  }
  for (const auto& [group, tets] : mesh.element_groups)
    for (TetIndex t = 0; t < result.tets.size(); ++t) result.element_groups[group].push_back(t);
  return result;
}

}  // namespace forefeel
