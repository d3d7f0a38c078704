// Polygons become triangles. A convex one is a fan from its first corner. Any other is triangulated by CGAL in the
// plane of its mean normal (Newell's).
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <utility>

#include "geometry/meshing/surface_ply.hpp"

namespace forefeel {
namespace {

using Kernel2 = CGAL::Exact_predicates_inexact_constructions_kernel;
using Corners2 = CGAL::Triangulation_data_structure_2<
    CGAL::Triangulation_vertex_base_with_info_2<NodeIndex, Kernel2>,
    CGAL::Constrained_triangulation_face_base_2<
        Kernel2, CGAL::Triangulation_face_base_with_info_2<int, Kernel2>>>;  // info: 1 inside, -1 outside
using Plane2 =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel2, Corners2, CGAL::No_constraint_intersection_tag>;
using Point2 = Kernel2::Point_2;
using Edges =
    std::map<std::pair<Plane2::Vertex_handle, Plane2::Vertex_handle>, int>;  // how often each is walked

std::pair<Plane2::Vertex_handle, Plane2::Vertex_handle> edge_of(Plane2::Vertex_handle a,
                                                                Plane2::Vertex_handle b) {
  return a < b ? std::pair(a, b) : std::pair(b, a);
}

double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x() - a.x()) * (c.y() - b.y()) - (b.y() - a.y()) * (c.x() - b.x());
}

// All turns to the left, and once around.
bool is_convex(const std::vector<Point2>& corners, double area) {
  const std::size_t n = corners.size();
  double around = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Point2 &a = corners[i], &b = corners[(i + 1) % n], &c = corners[(i + 2) % n];
    const double left = turn(a, b, c);
    if (left < -1e-9 * area) return false;
    around += std::atan2(left, (b - a) * (c - b));
  }
  return around < 3 * M_PI;
}

// Labels the faces on this side of the edges that are walked an odd number of times. A polygon with a hole walks the
// bridge to it twice.
void mark_inside(Plane2& plane, const Edges& walked) {
  std::vector<Plane2::Face_handle> front{plane.infinite_face()};
  front.back()->info() = -1;
  while (!front.empty()) {
    const Plane2::Face_handle face = front.back();
    front.pop_back();
    for (int side = 0; side < 3; ++side) {
      const Plane2::Face_handle next = face->neighbor(side);
      if (next->info() != 0) continue;
      const auto found =
          walked.find(edge_of(face->vertex(Plane2::cw(side)), face->vertex(Plane2::ccw(side))));
      const bool border = face->is_constrained(side) && (found == walked.end() || found->second % 2 == 1);
      next->info() = border ? -face->info() : face->info();
      front.push_back(next);
    }
  }
}

void add_fan(std::span<const NodeIndex> polygon, std::vector<Triangle>& to) {
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) to.push_back({polygon[0], polygon[k], polygon[k + 1]});
}

}  // namespace

PolygonCut cut_polygon(std::span<const Vec3> nodes, std::span<const NodeIndex> polygon,
                       std::vector<Triangle>& to) {
  PolygonCut cut;
  const std::size_t n = polygon.size();
  if (n < 4) {
    add_fan(polygon, to);
    return cut;
  }
  const Vec3 origin = nodes[polygon[0]];
  Vec3 normal = Vec3::Zero(), mean = Vec3::Zero();
  double size = 0, swept = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 a = nodes[polygon[i]] - origin, b = nodes[polygon[(i + 1) % n]] - origin;
    normal += 0.5 * a.cross(b);
    swept += 0.5 * a.cross(b).norm();
    mean += a / static_cast<double>(n);
    size = std::max(size, a.norm());
  }
  const double area = normal.norm();
  if (!(area > 1e-12 * size * size)) {
    cut.crosses = swept > 1e-9 * size * size;  // parts that cancel
    add_fan(polygon, to);
    return cut;
  }
  normal /= area;
  const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<Point2> corners;
  for (const NodeIndex node : polygon) {
    const Vec3 at = nodes[node] - origin;
    cut.off_plane = std::max(cut.off_plane, std::abs(normal.dot(at - mean)) / size);
    corners.emplace_back(u.dot(at), v.dot(at));
  }
  cut.convex = is_convex(corners, area);
  if (cut.convex) {
    add_fan(polygon, to);
    return cut;
  }
  try {
    Plane2 plane;
    std::vector<Plane2::Vertex_handle> vertices;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t before = plane.number_of_vertices();
      vertices.push_back(plane.insert(corners[i]));
      if (plane.number_of_vertices() > before) vertices.back()->info() = polygon[i];
    }
    Edges walked;
    for (std::size_t i = 0; i < n; ++i) {
      const Plane2::Vertex_handle a = vertices[i], b = vertices[(i + 1) % n];
      if (a == b) continue;
      if (walked[edge_of(a, b)]++ == 0) plane.insert_constraint(a, b);
    }
    for (const Plane2::Face_handle face : plane.all_face_handles()) face->info() = 0;
    mark_inside(plane, walked);
    for (const Plane2::Face_handle face : plane.finite_face_handles())
      if (face->info() == 1)
        to.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  } catch (const Plane2::Intersection_of_constraints_exception&) {
    cut.crosses = true;
    add_fan(polygon, to);
  }
  return cut;
}

}  // namespace forefeel
