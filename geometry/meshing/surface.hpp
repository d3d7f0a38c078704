#pragma once
// Triangle surfaces: reading, repair, and tetrahedralisation with a given number of elements. Lengths in [m].

#include <atomic>
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

inline constexpr const char* surface_extensions = ".obj .off .stl .ply .vtp, or .vtk with DATASET POLYDATA";
// Decided by the extension; for .vtk also by the content.
bool is_surface_file(const std::filesystem::path& file);

// .obj .off .stl .ply .vtp, legacy .vtk; ASCII, binary. Coinciding points are one node. InputError: file, line.
Surface read_surface(const std::filesystem::path& file);

Surface boundary_surface(const TetMesh& mesh);   // outward; nodes in the order of the mesh, renumbered
double enclosed_volume(const Surface& surface);  // [m^3], positive where the triangles face outward
Box bounding_box(const Surface& surface);        // of its triangles; other nodes do not count
Vec3 nearest_point(const Surface& surface, const Vec3& point);  // of the surface

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

struct TetrahedraliseOptions {
  std::size_t elements = 0;                     // wanted number, met within 5 %; 0: as the surface is
  std::optional<double> length = std::nullopt;  // rescale so that the longest side is this [m]
  std::string name = "surface";                 // what errors call it
  // For everything, repair and all tries included [s]. Not given: default_time_limit(elements).
  std::optional<double> time_limit = std::nullopt;
  const std::atomic<bool>* stop = nullptr;  // once true, it ends with an InputError "interrupted"
  // With any of these the triangles are remeshed by graded_surface.hpp, and `elements` is needed.
  std::optional<Toward> toward = std::nullopt;  // small elements there; otherwise edges are even
  std::optional<LowEnd> rim = std::nullopt;     // of the clamp: edges of the mesh run along it
  std::vector<int> marks = {};                  // by triangle; borders between different marks stay edges
  std::vector<Vec3> pins = {};                  // places of nodes that stay [m]
};
double default_time_limit(std::size_t elements);  // 120, or 1 for each 5000 elements if that is more [s]

struct TetrahedraliseReport {
  RepairReport repair;
  double hausdorff = 0;      // between the input surface and the boundary of the mesh [m]
  double near = 0, far = 0;  // edges wanted at the contact and far from it [m]; 0: not graded
};

// Repairs and decimates a surface and fills it with TetGen. Bisection finds the volume bound that gives the
// wanted number of elements. Runs in a child process, because CGAL and TetGen hang, crash or print on some inputs.
// InputError if the number cannot be met, if the time is up, or if the body is not 1e-6 to 1e6 m long.
TetMesh tetrahedralise(const Surface& surface, const TetrahedraliseOptions& options,
                       TetrahedraliseReport* report = nullptr);

}  // namespace forefeel
