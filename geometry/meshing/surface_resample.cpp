// Decimation, remeshing and distances by CGAL. Only this file includes those headers.

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Polygon_mesh_processing/detect_features.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_ratio_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/common/error.hpp"
#include "geometry/meshing/surface_cgal.hpp"
#include "geometry/meshing/surface_process.hpp"

namespace forefeel {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
namespace SMS = CGAL::Surface_mesh_simplification;
using cgal::Mesh;
using cgal::Point;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<cgal::Kernel, CGAL::AABB_face_graph_triangle_primitive<Mesh>>>;

void decimate(Mesh& mesh, double share) {
  SMS::GarlandHeckbert_plane_policies<Mesh, cgal::Kernel> policies(mesh);
  SMS::Count_ratio_stop_predicate<Mesh> stop(share);
  SMS::edge_collapse(mesh, stop,
                     CGAL::parameters::get_cost(policies.get_cost()).get_placement(policies.get_placement()));
  mesh.collect_garbage();
}

// Largest distance from points of `from`, no more than `step` apart, to `to`.
double one_sided_distance(const Surface& from, const Surface& to, double step) {
  const cgal::Soup soup = cgal::to_soup(to);
  Mesh mesh;  // each triangle on its own: the input may be non-manifold
  for (const auto& face : soup.second) {
    const auto a = mesh.add_vertex(soup.first[face[0]]), b = mesh.add_vertex(soup.first[face[1]]),
               c = mesh.add_vertex(soup.first[face[2]]);
    if (!CGAL::collinear(mesh.point(a), mesh.point(b), mesh.point(c))) mesh.add_face(a, b, c);
  }
  if (mesh.number_of_faces() == 0) return 0;
  Tree tree(faces(mesh).first, faces(mesh).second, mesh);
  tree.build();
  double largest = 0;
  for (const auto& [ia, ib, ic] : from.triangles) {
    const Vec3 &a = from.nodes[ia], u = from.nodes[ib] - a, v = from.nodes[ic] - a;
    const double longest = std::max({u.norm(), v.norm(), (u - v).norm()});
    const int n = std::clamp(static_cast<int>(std::ceil(longest / step)), 1, 200);
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) {
        const Vec3 q = a + (u * i + v * j) / n;
        largest = std::max(largest, CGAL::to_double(tree.squared_distance(Point(q.x(), q.y(), q.z()))));
      }
  }
  return std::sqrt(largest);
}

}  // namespace

double surface_area(const Surface& surface) {
  double sum = 0;
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3& origin = surface.nodes[a];
    sum += (surface.nodes[b] - origin).cross(surface.nodes[c] - origin).norm() / 2;
  }
  return sum;
}

Surface decimated(const Surface& surface, double share) {
  Mesh mesh = cgal::to_mesh(surface);
  try {
    decimate(mesh, share);
  } catch (const CGAL::Failure_exception&) {
    return surface;
  }
  return cgal::from_mesh(mesh);
}

Surface resample_surface(const Surface& surface, double edge) {
  Mesh mesh = cgal::to_mesh(surface);
  const double wanted = forefeel::surface_area(surface) / (std::sqrt(3.0) / 4 * edge * edge);
  const double far_finer = static_cast<double>(surface.triangles.size()) / (6 * wanted);
  try {
    if (far_finer > 1) decimate(mesh, 1 / far_finer);
    auto sharp = get(CGAL::edge_is_feature, mesh);
    PMP::detect_sharp_edges(mesh, 50, sharp);
    PMP::isotropic_remeshing(
        mesh.faces(), edge, mesh,
        CGAL::parameters::number_of_iterations(5).number_of_relaxation_steps(3).edge_is_constrained_map(
            sharp));
  } catch (const CGAL::Failure_exception&) {
    return surface;
  }
  return cgal::from_mesh(mesh);
}

double hausdorff_distance(const Surface& a, const Surface& b, double step) {
  if (!(step > 0)) step = bounding_box(a).size().norm() / 300;
  return std::max(one_sided_distance(a, b, step), one_sided_distance(b, a, step));
}

}  // namespace forefeel
