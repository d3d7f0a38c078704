// Repair by CGAL's Polygon Mesh Processing. Only this file includes those headers.

#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/alpha_wrap_3.h>

#include "geometry/common/error.hpp"
#include "geometry/meshing/surface_cgal.hpp"
#include "geometry/meshing/surface_process.hpp"

namespace forefeel {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using cgal::Mesh;
using cgal::Soup;

// Orients the triangles consistently, splits non-manifold edges and vertices, and sews borders.
Mesh sewn(Soup soup, bool& reoriented) {
  auto& [points, polygons] = soup;
  PMP::repair_polygon_soup(points, polygons);
  reoriented = !PMP::is_polygon_soup_a_polygon_mesh(polygons);
  if (reoriented) PMP::orient_polygon_soup(points, polygons);
  Mesh mesh;
  PMP::polygon_soup_to_polygon_mesh(points, polygons, mesh);
  PMP::stitch_borders(mesh);
  return mesh;
}

std::size_t count_self_intersections(const Mesh& mesh) {
  std::vector<std::pair<Mesh::Face_index, Mesh::Face_index>> pairs;
  PMP::self_intersections(mesh, std::back_inserter(pairs));
  return pairs.size();
}

std::size_t fill_holes(Mesh& mesh) {
  std::vector<Mesh::Halfedge_index> cycles;
  PMP::extract_boundary_cycles(mesh, std::back_inserter(cycles));
  for (const auto cycle : cycles) {
    std::vector<Mesh::Face_index> patch;
    PMP::triangulate_hole(mesh, cycle, std::back_inserter(patch));
  }
  return cycles.size();
}

// Removes parts without volume (crumbs, folded sheets); returns the number of parts that stay.
std::size_t drop_crumbs(Mesh& mesh) {
  auto part = mesh.add_property_map<Mesh::Face_index, std::size_t>("f:part").first;
  const std::size_t parts = PMP::connected_components(mesh, part);
  std::vector<double> six_volumes(parts, 0);
  const cgal::Point origin =
      mesh.number_of_vertices() ? mesh.point(*mesh.vertices().begin()) : cgal::Point(0, 0, 0);
  for (const auto f : mesh.faces()) {
    cgal::Point corner[3];
    int k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) corner[k++] = mesh.point(v);
    six_volumes[part[f]] += 6 * CGAL::to_double(CGAL::volume(origin, corner[0], corner[1], corner[2]));
  }
  double largest = 0;
  for (double& volume : six_volumes) largest = std::max(largest, volume = std::abs(volume));
  std::vector<std::size_t> keep;
  for (std::size_t i = 0; i < parts; ++i)
    if (six_volumes[i] > 1e-6 * largest) keep.push_back(i);
  if (keep.size() < parts) PMP::keep_connected_components(mesh, keep, part);
  mesh.remove_property_map(part);
  mesh.collect_garbage();
  return keep.size();
}

bool is_solid(const Mesh& mesh) {
  return !mesh.is_empty() && CGAL::is_closed(mesh) && !PMP::does_self_intersect(mesh);
}

// Repairs in place. False if local repair cannot make the mesh a closed solid. patched: the surface with its holes
// filled. A wrap of it stays outside, where one of an open surface enters through the holes and gives a thin shell.
bool repair_locally(Mesh& mesh, RepairReport& report, Surface& patched) {
  report.holes = fill_holes(mesh);
  if (report.holes > 0) patched = cgal::from_mesh(mesh);
  if (!CGAL::is_closed(mesh)) return false;
  report.components = drop_crumbs(mesh);
  if (report.self_intersections > 0) {
    report.crossing = cgal::unite_crossing_parts(mesh, report.united);
    if (report.crossing > 0 && !report.united) return false;  // local repair would cut the parts open
  }
  if (report.self_intersections > 0 || PMP::does_self_intersect(mesh))
    PMP::experimental::remove_self_intersections(mesh);
  return is_solid(mesh);
}

double diagonal(const Surface& surface) {
  return bounding_box(surface).size().norm();
}

}  // namespace

bool intersects_itself(const Surface& surface) {
  return PMP::does_self_intersect(cgal::to_mesh(surface));
}

Surface alpha_wrap(const Surface& surface, double alpha) {
  const Soup soup = cgal::to_soup(surface);
  Mesh mesh;
  CGAL::alpha_wrap_3(soup.first, soup.second, alpha, alpha / 20, mesh);
  return cgal::from_mesh(mesh);
}

Surface repair_surface(const Surface& surface, RepairReport& report) {
  report = {};
  report.triangles_before = surface.triangles.size();
  if (!(diagonal(surface) > 0)) throw InputError("surface", "has no extent, expected a closed surface");
  Mesh mesh = sewn(cgal::to_soup(surface), report.reoriented);
  report.self_intersections = count_self_intersections(mesh);
  Surface result, patched = surface;
  bool solid = false;
  try {
    solid = repair_locally(mesh, report, patched);
    if (solid) {
      const double before = PMP::volume(mesh);
      PMP::orient_to_bound_a_volume(mesh);
      report.reoriented = report.reoriented || before < 0;
    }
  } catch (const CGAL::Failure_exception&) {
    solid = false;  // the wrap below accepts any input
  }
  if (solid) {
    result = cgal::from_mesh(mesh);
  } else {
    result = alpha_wrap(patched, diagonal(surface) / 60);
    report.wrapped = true;
    report.united = false;
    Mesh wrapped = cgal::to_mesh(result);
    report.components = drop_crumbs(wrapped);
    result = cgal::from_mesh(wrapped);
    // The wrap of an open sheet is a shell twice its offset thick; such a thin result is refused.
    const double offset = diagonal(surface) / 60 / 20;
    if (enclosed_volume(result) < 1.5 * offset * surface_area(result)) {
      throw InputError("surface", "encloses no volume, expected a closed surface");
    }
  }
  const double side = bounding_box(result).size().maxCoeff();
  if (!(enclosed_volume(result) > 1e-9 * side * side * side))
    throw InputError("surface", "encloses no volume, expected a closed surface");
  report.volume = enclosed_volume(result);
  report.triangles_after = result.triangles.size();
  return result;
}

}  // namespace forefeel
