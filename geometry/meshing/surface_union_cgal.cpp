#include "geometry/meshing/surface_cgal.hpp"

#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "geometry/common/union_find.hpp"

namespace forefeel::cgal {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;

struct Crossings {
  std::vector<std::vector<std::size_t>> groups;  // of parts that cross, each of two or more
  bool within = false;                           // a part of a group crosses itself
  std::size_t parts = 0;                         // in the groups
};

template <class PartOf>
Crossings crossings_of(const Mesh& mesh, const PartOf& part, std::size_t count) {
  std::vector<std::pair<Mesh::Face_index, Mesh::Face_index>> pairs;
  PMP::self_intersections(mesh, std::back_inserter(pairs));
  UnionFind sets(count);
  std::vector<char> crosses(count, 0), itself(count, 0);
  for (const auto& [a, b] : pairs) {
    const std::size_t p = part[a], q = part[b];
    if (p == q) {
      itself[p] = 1;
      continue;
    }
    crosses[p] = crosses[q] = 1;
    sets.join(static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(q));
  }
  std::vector<std::vector<std::size_t>> by_root(count);
  Crossings found;
  for (std::size_t p = 0; p < count; ++p) {
    if (!crosses[p]) continue;
    by_root[sets.find(static_cast<std::uint32_t>(p))].push_back(p);
    found.within = found.within || itself[p];
    ++found.parts;
  }
  for (auto& group : by_root)
    if (!group.empty()) found.groups.push_back(std::move(group));
  return found;
}

// The union of parts, each turned outward.
bool unite(std::vector<Mesh>& parts, const std::vector<std::size_t>& group, Mesh& sum) {
  for (const std::size_t p : group) {
    Mesh& next = parts[p];
    if (!PMP::is_outward_oriented(next)) PMP::reverse_face_orientations(next);
    if (p == group.front()) {
      sum = next;
      continue;
    }
    Mesh both;
    if (!PMP::corefine_and_compute_union(sum, next, both)) return false;
    sum = std::move(both);
    sum.collect_garbage();
  }
  return true;
}

}  // namespace

std::size_t unite_crossing_parts(Mesh& mesh, bool& united) {
  united = false;
  auto part = mesh.add_property_map<Mesh::Face_index, std::size_t>("f:part of a union").first;
  const std::size_t count = PMP::connected_components(mesh, part);
  const Crossings crossings = count > 1 ? crossings_of(mesh, part, count) : Crossings{};
  if (crossings.parts == 0 || crossings.within || !CGAL::is_closed(mesh)) {
    mesh.remove_property_map(part);
    return crossings.parts;
  }
  std::vector<Mesh> parts;
  PMP::split_connected_components(mesh, parts, CGAL::parameters::face_patch_map(part));
  mesh.remove_property_map(part);
  std::vector<char> in_group(parts.size(), 0);
  Mesh result;
  for (const auto& group : crossings.groups) {
    Mesh sum;
    if (!unite(parts, group, sum)) return crossings.parts;
    for (const std::size_t p : group) in_group[p] = 1;
    result.join(sum);
  }
  for (std::size_t p = 0; p < parts.size(); ++p)
    if (!in_group[p]) result.join(parts[p]);
  mesh = std::move(result);
  united = true;
  return crossings.parts;
}

}  // namespace forefeel::cgal
