#pragma once
// Triangle surfaces: reading, repair, decimation, and tetrahedralisation to an asked element count.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

struct Surface {
  std::vector<Vec3> nodes;  // [m]
  std::vector<Triangle> triangles;
};

bool is_surface_file(const std::filesystem::path& file);  // by extension

// .obj .off .stl (ASCII and binary) .ply (ASCII and binary). InputError names file and line.
Surface read_surface(const std::filesystem::path& file);

Surface boundary_surface(const TetMesh& mesh);   // outward; nodes renumbered, in the order of the mesh
double enclosed_volume(const Surface& surface);  // [m^3], positive where the triangles face outward
Box bounding_box(const Surface& surface);

struct RepairReport {
  std::size_t self_intersections = 0;  // pairs of triangles in the input
  std::size_t holes = 0;
  std::size_t components = 0;
  bool reoriented = false;
  bool wrapped = false;  // rebuilt by an alpha wrap because local repair did not suffice
  std::size_t triangles_before = 0, triangles_after = 0;
};

// A closed, outward, self-intersection-free surface close to the input (CGAL: polygon soup repair, orientation,
// hole filling, self-intersection removal; alpha wrap as the last resort).
Surface repair(const Surface& surface, RepairReport& report);

// Largest distance from a point of either surface to the other, sampled every `step` [m] (0: a 300th of the diagonal).
double hausdorff_distance(const Surface& a, const Surface& b, double step = 0);

struct TetrahedraliseOptions {
  std::size_t elements = 0;                     // asked count, met within 5 %; 0: as the surface gives
  std::optional<double> length = std::nullopt;  // rescale so that the longest side is this [m]
  std::string name = "surface";                 // named in errors
};

struct TetrahedraliseReport {
  RepairReport repair;
  double hausdorff = 0;  // largest distance between input surface and mesh boundary, both ways [m]
};

// Repairs, decimates and fills a surface (TetGen, volume bound bisected). InputError if the count cannot be met.
TetMesh tetrahedralise(const Surface& surface, const TetrahedraliseOptions& options,
                       TetrahedraliseReport* report = nullptr);

}  // namespace forefeel
