#pragma once
// From a closed surface to graded tetrahedra: the size field of a request, and the fill of a graded surface. Private to
// this room.

#include "geometry/meshing/graded_skin.hpp"
#include "geometry/meshing/tet_fill.hpp"

namespace forefeel {

bool is_graded(const TetrahedraliseOptions& options);

// Of a repaired surface. Without a contact all edges are wanted alike.
SizeField size_field_of(const Surface& closed, const TetrahedraliseOptions& options);

// The marks of the input's triangles, on the surface that its repair gave: those of the nearest ones.
std::vector<int> marks_on(const Surface& repaired, const Surface& input, std::span<const int> marks);

// As fill_to_count(), with the volume of each tetrahedron bound by a multiple of the cube of the wanted edge.
CountedFill fill_graded(const GradedSurface& skin, const SizeField& size, std::size_t elements, double share,
                        TetFillOptions options = {});

}  // namespace forefeel
