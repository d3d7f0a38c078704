#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>

#include "geometry/meshing/tet_fill.hpp"

namespace forefeel {
namespace {

Triangle sorted(Triangle t) {
  std::ranges::sort(t);
  return t;
}

// Number of the region of each tetrahedron. A region is connected without crossing the surface.
std::vector<TetIndex> regions_of(const TetMesh& mesh, const Surface& surface) {
  std::set<Triangle> walls;
  for (const Triangle& t : surface.triangles) walls.insert(sorted(t));
  std::vector<std::pair<Triangle, TetIndex>> sides;
  for (TetIndex t = 0; t < mesh.tets.size(); ++t)
    for (std::size_t k = 0; k < 4; ++k) {
      const Tet& tet = mesh.tets[t];
      sides.emplace_back(sorted({tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]}), t);
    }
  std::ranges::sort(sides);
  std::vector<TetIndex> parent(mesh.tets.size());
  std::iota(parent.begin(), parent.end(), TetIndex{0});
  const auto root = [&](TetIndex i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t i = 0; i + 1 < sides.size(); ++i)
    if (sides[i].first == sides[i + 1].first && !walls.contains(sides[i].first))
      parent[root(sides[i + 1].second)] = root(sides[i].second);
  for (TetIndex t = 0; t < parent.size(); ++t) parent[t] = root(t);
  return parent;
}

// Solid angle of a triangle seen from q, over 4 pi (Van Oosterom and Strackee 1983).
double solid_angle(const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 u = a - q, v = b - q, w = c - q;
  const double lu = u.norm(), lv = v.norm(), lw = w.norm();
  const double denominator = lu * lv * lw + u.dot(v) * lw + v.dot(w) * lu + w.dot(u) * lv;
  return 2 * std::atan2(u.dot(v.cross(w)), denominator) / (4 * std::numbers::pi);
}

double winding_number(const Surface& surface, const Vec3& q) {
  double sum = 0;
  for (const auto& [a, b, c] : surface.triangles)
    sum += solid_angle(q, surface.nodes[a], surface.nodes[b], surface.nodes[c]);
  return sum;
}

// Removes nodes that no tetrahedron uses, except those of the surface, which come first.
void compact(TetMesh& mesh, std::size_t keep) {
  std::vector<char> used(mesh.nodes.size(), 0);
  std::fill_n(used.begin(), std::min(keep, used.size()), char{1});
  for (const Tet& tet : mesh.tets)
    for (const NodeIndex node : tet) used[node] = 1;
  std::vector<NodeIndex> number(mesh.nodes.size());
  NodeIndex next = 0;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i]) mesh.nodes[next] = mesh.nodes[i], number[i] = next++;
  mesh.nodes.resize(next);
  for (Tet& tet : mesh.tets)
    for (NodeIndex& node : tet) node = number[node];
}

}  // namespace

void drop_cavities(TetMesh& mesh, const Surface& surface) {
  const std::vector<TetIndex> region = regions_of(mesh, surface);
  std::vector<int> inside(mesh.tets.size(), -1);  // by region; -1: not yet known
  std::vector<Tet> kept;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    int& known = inside[region[t]];
    if (known < 0) {
      Vec3 centre = Vec3::Zero();
      for (const NodeIndex node : mesh.tets[t]) centre += mesh.nodes[node] / 4;
      known = winding_number(surface, centre) > 0.5;
    }
    if (known) kept.push_back(mesh.tets[t]);
  }
  if (kept.size() == mesh.tets.size()) return;
  mesh.tets = std::move(kept);
  compact(mesh, surface.nodes.size());
}

}  // namespace forefeel
