#pragma once
// Lines on a surface that a mesh of it keeps as edges: sharp edges, borders between marked triangles, and the rim of a
// clamp. Private to this room.

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

using Link = std::array<NodeIndex, 2>;  // an edge, lower node first

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

}  // namespace forefeel
