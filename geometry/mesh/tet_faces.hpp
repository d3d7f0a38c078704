#pragma once
// The faces of a tetrahedral mesh, sorted so that the faces of two tetrahedra that share three nodes are neighbours.

#include <cstdint>
#include <vector>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

// Faces of a positively oriented tetrahedron, each counter-clockwise seen from outside; face i is opposite
// node i.
constexpr unsigned tet_faces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

struct TetFace {
  Triangle sorted;  // key
  TetIndex tet;
  std::uint8_t side;
  bool even;  // parity of the outward order against the sorted one
};

std::vector<TetFace> sorted_faces(const TetMesh& mesh);

}  // namespace forefeel
