#pragma once
// From a closed surface to graded tetrahedra: the lines that a mesh of it keeps as edges (sharp edges, borders between
// marked triangles, the rim of a clamp), surfaces with triangles graded toward a contact and with edges along these
// lines (graded_surface.hpp), and the fill of a graded surface. Private to this room.

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "geometry/meshing/graded_surface.hpp"
#include "geometry/meshing/tet_fill.hpp"

namespace forefeel {

// The plane of a rim: coordinate of the axis [m].
double rim_level(const Box& box, const LowEnd& low_end);

// Cuts the triangles along a plane at right angles to an axis. The new nodes have exactly its coordinate.
void cut_at(Surface& surface, Axis axis, double level);

// Edges between triangles of different marks, sorted. Marks: one number a triangle.
std::vector<Link> borders(const Surface& surface, std::span<const int> marks);
// Marks for the rim of a surface that was cut there: 1 where no node lies above the level.
std::vector<int> marks_below(const Surface& surface, Axis axis, double level);
// Edges whose triangles make an angle of more than 50 degrees, sorted.
std::vector<Link> sharp_edges(const Surface& surface);

// Nodes where lines end, meet, or turn by an angle of less than this cosine, sorted.
std::vector<NodeIndex> corners_of(const Surface& surface, std::span<const Link> lines, double turn_cosine);

// The nearest point of the lines; there is at least one.
std::function<Vec3(const Vec3&)> nearest_on_lines(const Surface& surface, std::span<const Link> lines);

// Of a repaired surface: its sharp edges, the rim (low end), the borders between marks and the pins are kept.
struct SkinOptions {
  std::optional<LowEnd> rim = {};
  std::span<const int> marks = {};  // by triangle of the surface; empty: none
  std::span<const Vec3> pins = {};  // [m]; the node nearest to each is moved onto it
  bool keep_sharp = true;           // edges of more than 50 degrees
};
GradedSurface graded_skin(const Surface& closed, const SkinOptions& options, const SizeField& size);

// Of a smooth body about which everything is known.
struct SmoothSkin {
  Surface start;                                    // nodes on the surface
  std::function<Vec3(const Vec3&)> onto;            // the surface
  std::function<Vec3(const Vec3&, Axis)> onto_cut;  // the surface, with the coordinate of that axis as it is
  Axis axis = Axis::z;                              // of the rim
  double level = 0;                                 // of the rim [m]
  std::vector<Vec3> pins = {};                      // [m]
};
GradedSurface graded_skin(const SmoothSkin& body, const SizeField& size);

// Without self-intersections, by local repair; what it replaces is no longer held. Nothing where that fails.
std::optional<GradedSurface> without_intersections(GradedSurface surface);

// The marks of the input's triangles, on the surface that its repair gave: those of the nearest ones.
std::vector<int> marks_on(const Surface& repaired, const Surface& input, std::span<const int> marks);

// As fill_to_count(), with the volume of each tetrahedron bound by a multiple of the cube of the wanted edge.
CountedFill fill_graded(const GradedSurface& skin, const SizeField& size, std::size_t elements, double share,
                        TetFillOptions options = {});

}  // namespace forefeel
