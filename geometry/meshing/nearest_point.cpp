#include "geometry/meshing/nearest_point.hpp"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>

#include <memory>

#include "geometry/meshing/surface_cgal.hpp"

namespace forefeel {
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
