#pragma once
// Improves the shape of tetrahedra:
//   flat tetrahedra on the surface are removed, as if an edge of the surface were flipped
//   inner faces and edges are flipped: 2-3; 3-2, 4-4 and larger rings by Klincsek's dynamic programme (1980)
//   inner nodes move; nodes of the surface move by a few hundredths of an edge, and only next to very bad
//   tetrahedra
// A flip or move is kept only if the worst dihedral angle of the tetrahedra that it touches grows.
// Deterministic.

#include <cstddef>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

struct ImproveOptions {
  std::size_t fixed_nodes = 0;  // the first `fixed_nodes` nodes lie on the surface and stay in place
  int rounds = 4;
  bool flips = true;          // false: only nodes move; tetrahedra and their numbers stay
  double peel_below_deg = 6;  // a flat tetrahedron on the surface is removed below this dihedral angle [deg]
};

void improve_shapes(TetMesh& mesh, const ImproveOptions& options);

}  // namespace forefeel
