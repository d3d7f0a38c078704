// Decimation, remeshing, distances and nearest points by CGAL. Only this file includes those headers.

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Polygon_mesh_processing/detect_features.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_ratio_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

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

// ---- nearest points

namespace {

using Facets = std::vector<cgal::Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<cgal::Kernel, Facets::const_iterator>;
using FacetTree = CGAL::AABB_tree<CGAL::AABB_traits<cgal::Kernel, Primitive>>;

struct Index {
  Facets facets;
  std::vector<std::size_t> number;  // of each facet, in the surface
  FacetTree tree;
};

cgal::Point point_of(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

}  // namespace

std::function<NearestPoint(const Vec3&)> nearest_on(const Surface& surface) {
  const auto index = std::make_shared<Index>();
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    const cgal::Kernel::Triangle_3 facet(point_of(surface.nodes[a]), point_of(surface.nodes[b]),
                                         point_of(surface.nodes[c]));
    if (facet.is_degenerate()) continue;
    index->facets.push_back(facet);
    index->number.push_back(t);
  }
  index->tree.insert(index->facets.cbegin(), index->facets.cend());
  index->tree.build();
  return [index](const Vec3& p) {
    const auto [point, at] = index->tree.closest_point_and_primitive(point_of(p));
    return NearestPoint{Vec3(point.x(), point.y(), point.z()),
                        index->number[static_cast<std::size_t>(at - index->facets.cbegin())]};
  };
}

Vec3 nearest_point(const Surface& surface, const Vec3& point) {
  return nearest_on(surface)(point).point;
}

}  // namespace forefeel
