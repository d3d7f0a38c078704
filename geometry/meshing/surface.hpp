#pragma once
// Triangle surfaces: reading, measures and repair. Lengths in [m].

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

struct Surface {
  std::vector<Vec3> nodes;  // [m]
  std::vector<Triangle> triangles;
  std::vector<std::string> remarks = {};  // on faces of its file, with their lines
};

inline constexpr const char* surface_extensions = ".obj .off .stl .ply, or .vtk with DATASET POLYDATA";
// Decided by the extension; for .vtk also by the content.
bool is_surface_file(const std::filesystem::path& file);

// .obj .off .stl .ply, legacy .vtk; ASCII, binary. Coinciding points are one node. InputError: file, line.
Surface read_surface(const std::filesystem::path& file);

Surface boundary_surface(const TetMesh& mesh);   // outward; nodes in the order of the mesh, renumbered
double enclosed_volume(const Surface& surface);  // [m^3], positive where the triangles face outward
Box bounding_box(const Surface& surface);        // of its triangles; other nodes do not count
Vec3 nearest_point(const Surface& surface, const Vec3& point);  // of the surface

// What a surface is made of, and whether it is closed: every edge belongs to exactly two triangles.
struct SurfaceSummary {
  std::size_t nodes = 0, triangles = 0;
  std::size_t border_edges = 0;        // of one triangle
  std::size_t non_manifold_edges = 0;  // of more than two
  double volume = 0;                   // [m^3]; NaN if the surface is not closed
  Box box;                             // [m]

  bool closed() const { return border_edges == 0 && non_manifold_edges == 0; }
};

SurfaceSummary summarise(const Surface& surface);

struct RepairReport {
  std::size_t self_intersections = 0;  // pairs of triangles in the input
  std::size_t holes = 0;
  std::size_t components = 0;
  std::size_t crossing = 0;  // parts that crossed another one
  bool united = false;       // the body is their union
  bool reoriented = false;
  bool wrapped = false;  // local repair failed; rebuilt as an alpha wrap
  std::size_t triangles_before = 0, triangles_after = 0;
  double volume = 0;  // of the repaired surface [m^3]
};

// A closed surface near the input, outward, without self-intersections. By CGAL: polygon soup repair,
// orientation, hole filling, union of parts that cross, removal of self-intersections; if that fails, an alpha wrap.
// InputError if it encloses no volume.
Surface repair_surface(const Surface& surface, RepairReport& report);

// Hausdorff distance [m]: the largest distance from a point of either surface to the other one. Sampled every
// `step` [m]; 0: a 300th of the diagonal.
double hausdorff_distance(const Surface& a, const Surface& b, double step = 0);

// The ball of a contact. Elements are small in it and grow with the distance from it (size_field.hpp).
struct Toward {
  Vec3 site = Vec3::Zero();  // [m]; taken to the nearest point of the surface
  double radius = 0;         // [m]
};

// The part of a body at the low end of an axis, as nodes_below() chooses its nodes (tet_mesh.hpp). Its rim is the
// surface's section with the plane at `share` of the extent.
struct LowEnd {
  Axis axis = Axis::z;
  double share = 0;  // between 0 and 1
};

}  // namespace forefeel
