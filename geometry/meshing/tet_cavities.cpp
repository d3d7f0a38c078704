#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "geometry/common/union_find.hpp"
#include "geometry/meshing/tet_fill.hpp"
#include "geometry/meshing/tet_improve.hpp"

namespace forefeel {
namespace {

Triangle sorted(Triangle t) {
  std::ranges::sort(t);
  return t;
}

// Number of the region of each tetrahedron. A region is connected without crossing the surface.
std::vector<std::uint32_t> regions_of(const TetMesh& mesh, const Surface& surface) {
  std::set<Triangle> walls;
  for (const Triangle& t : surface.triangles) walls.insert(sorted(t));
  std::vector<std::pair<Triangle, std::uint32_t>> sides;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (std::size_t k = 0; k < 4; ++k) {
      const Tet& tet = mesh.tets[t];
      sides.emplace_back(sorted({tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]}),
                         static_cast<std::uint32_t>(t));
    }
  std::ranges::sort(sides);
  UnionFind sets(mesh.tets.size());
  for (std::size_t i = 0; i + 1 < sides.size(); ++i)
    if (sides[i].first == sides[i + 1].first && !walls.contains(sides[i].first))
      sets.join(sides[i].second, sides[i + 1].second);
  std::vector<std::uint32_t> region(mesh.tets.size());
  for (std::uint32_t t = 0; t < region.size(); ++t) region[t] = sets.find(t);
  return region;
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

}  // namespace

void drop_cavities(TetMesh& mesh, const Surface& surface) {
  const std::vector<std::uint32_t> region = regions_of(mesh, surface);
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
  drop_unused_nodes(mesh, surface.nodes.size());
}

}  // namespace forefeel
