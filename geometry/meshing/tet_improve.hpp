#pragma once
// Improves the shape of tetrahedra:
//   flat tetrahedra on the surface are removed, as if an edge of the surface were flipped
//   inner faces and edges are flipped: 2-3; 3-2, 4-4 and larger rings by Klincsek's dynamic programme (1980)
//   inner nodes move; nodes of the surface move by a few hundredths of an edge, and only next to very bad
//   tetrahedra
// A flip or move is kept only if the worst dihedral angle of the tetrahedra that it touches grows.
// Deterministic.

#include <cstddef>
#include <functional>
#include <vector>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

struct ImproveOptions {
  std::size_t fixed_nodes = 0;  // the first `fixed_nodes` nodes lie on the surface and stay in place
  bool flips = true;            // false: only nodes move; tetrahedra and their numbers stay
  // By node, as far as it goes: 1 stays in place even next to very bad tetrahedra, and an edge of the surface between
  // two of them stays.
  std::vector<char> held = {};
  std::function<Vec3(const Vec3&)> onto = {};  // if given, takes a moved node of the surface back to it
};

void improve_shapes(TetMesh& mesh, const ImproveOptions& options);

// Removes nodes that no tetrahedron uses, except the first `keep`; the others keep their order.
void drop_unused_nodes(TetMesh& mesh, std::size_t keep);

}  // namespace forefeel
