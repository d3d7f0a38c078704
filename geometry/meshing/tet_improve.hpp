#pragma once
// Better-shaped tetrahedra: slivers on the surface are peeled off (the same as turning one edge of the surface), faces
// and edges inside are flipped (2-3; 3-2, 4-4 and more by Klincsek's dynamic programme), inner nodes move, those of the
// surface by a few hundredths of an edge and only at really bad places. A flip or move is kept only where the worst
// angle of the tetrahedra it touches grows. The result depends on the input alone.

#include <cstddef>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

struct ImproveOptions {
  std::size_t fixed_nodes = 0;  // the first nodes stay where they are: those of the surface
  int rounds = 4;
  double peel_below_deg = 6;  // dihedral angle under which a sliver on the surface goes
};

void improve(TetMesh& mesh, const ImproveOptions& options);

}  // namespace forefeel
