#pragma once
// Boxes as regular meshes and as surfaces. Private to this room.

#include <array>
#include <cstddef>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

// A regular box mesh: cells cut into six tetrahedra along their diagonal (Kuhn), conforming as it stands.
TetMesh box_mesh(const Box& box, const std::array<int, 3>& cells);

bool within_share(std::size_t count, std::size_t asked);  // of 5 %

// Cell counts with 6 n_x n_y n_z within 5 % of the wanted number, and cells as near to cubes as possible.
// InputError where there are none.
std::array<int, 3> cells_for(const Vec3& size, std::size_t elements);

Surface box_surface(const Box& box);  // 12 triangles, outward

}  // namespace forefeel
