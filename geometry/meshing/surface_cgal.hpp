#pragma once
// Conversions between Surface and CGAL's types. Only the files that process surfaces with CGAL include this.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include "geometry/meshing/surface.hpp"

namespace forefeel::cgal {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Soup = std::pair<std::vector<Point>, std::vector<std::vector<std::size_t>>>;

inline Soup to_soup(const Surface& surface) {
  Soup soup;
  for (const Vec3& node : surface.nodes) soup.first.emplace_back(node.x(), node.y(), node.z());
  for (const auto& [a, b, c] : surface.triangles)
    soup.second.push_back(
        {static_cast<std::size_t>(a), static_cast<std::size_t>(b), static_cast<std::size_t>(c)});
  return soup;
}

inline Surface from_mesh(Mesh& mesh) {
  mesh.collect_garbage();
  Surface surface;
  for (const auto v : mesh.vertices())
    surface.nodes.emplace_back(mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z());
  for (const auto f : mesh.faces()) {
    Triangle triangle{};
    std::size_t k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f)))
      triangle[k++] = static_cast<NodeIndex>(v.idx());
    surface.triangles.push_back(triangle);
  }
  return surface;
}

// The surface must be manifold and consistently oriented.
inline Mesh to_mesh(const Surface& surface) {
  Mesh mesh;
  for (const Vec3& node : surface.nodes) mesh.add_vertex(Point(node.x(), node.y(), node.z()));
  for (const auto& [a, b, c] : surface.triangles)
    mesh.add_face(Mesh::Vertex_index(static_cast<Mesh::size_type>(a)),
                  Mesh::Vertex_index(static_cast<Mesh::size_type>(b)),
                  Mesh::Vertex_index(static_cast<Mesh::size_type>(c)));
  return mesh;
}

// Unites the parts of a closed surface that cross each other, such as segments that were appended to one file: the body
// is what any of them encloses. Parts that lie apart, or one inside another, stay as they are.
// Number of parts that cross another one. 0: the mesh is unchanged. Otherwise `united` says whether the mesh is now
// their union; false if a part crosses itself or CGAL's corefinement fails, and then the mesh is unchanged, too.
std::size_t unite_crossing_parts(Mesh& mesh, bool& united);

}  // namespace forefeel::cgal
