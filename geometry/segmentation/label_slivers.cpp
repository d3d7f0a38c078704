// Flat tetrahedra that perturbation and exudation leave are opened by moving nodes. No tetrahedron is added or removed,
// so each keeps its label.

#include <algorithm>
#include <cmath>

#include "geometry/meshing/tet_improve.hpp"
#include "geometry/segmentation/label_domain.hpp"

namespace forefeel {
namespace {

constexpr double flat = 5;  // dihedral angle [deg]

TetMesh as_mesh(const LabelledTets& mesh) {
  TetMesh result{.nodes = mesh.nodes, .tets = mesh.tets, .groups = {}};
  for (std::size_t t = 0; t < result.tets.size(); ++t)
    if (tet_volume(result, t) < 0) std::swap(result.tets[t][2], result.tets[t][3]);
  return result;
}

// Nodes with tetrahedra of more than one subdomain, or on the boundary.
std::vector<char> on_interfaces(const LabelledTets& mesh, const TetMesh& body) {
  std::vector<int> of(mesh.nodes.size(), 0);
  std::vector<char> result(mesh.nodes.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (const NodeIndex node : mesh.tets[t]) {
      int& its = of[node];
      if (its != 0 && its != mesh.subdomain[t]) result[node] = 1;
      its = mesh.subdomain[t];
    }
  for (const NodeIndex node : surface_nodes(body)) result[node] = 1;
  return result;
}

}  // namespace

bool has_flat_tets(const LabelledTets& mesh) {
  const TetMesh body = as_mesh(mesh);
  const double side = longest_side(body), least = 2e-14 * side * side * side;
  for (std::size_t t = 0; t < body.tets.size(); ++t)
    if (!(tet_volume(body, t) > least)) return true;
  return false;
}

void mend_slivers(LabelledTets& mesh) {
  TetMesh body = as_mesh(mesh);
  mesh.tets = body.tets;
  if (body.tets.empty() || mesh_quality(body).min_dihedral_deg >= flat) return;
  // Nodes of interfaces first, as improve_shapes() expects them.
  const std::vector<char> fixed = on_interfaces(mesh, body);
  std::vector<NodeIndex> order, number(fixed.size());
  for (const char kind : {char{1}, char{0}})
    for (std::size_t i = 0; i < fixed.size(); ++i)
      if (fixed[i] == kind)
        number[i] = static_cast<NodeIndex>(order.size()), order.push_back(static_cast<NodeIndex>(i));
  for (std::size_t i = 0; i < order.size(); ++i) body.nodes[i] = mesh.nodes[order[i]];
  for (Tet& tet : body.tets)
    for (NodeIndex& node : tet) node = number[node];
  improve_shapes(
      body, {.fixed_nodes = static_cast<std::size_t>(std::ranges::count(fixed, char{1})), .flips = false});
  for (std::size_t i = 0; i < order.size(); ++i) mesh.nodes[order[i]] = body.nodes[i];
}

}  // namespace forefeel
