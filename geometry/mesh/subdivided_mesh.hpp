#pragma once
// A mesh with each tetrahedron split into eight at the midpoints of its edges. Edges stay straight, so the shape is the
// same, and so are the node and element groups: the midpoint between two nodes of a group belongs to it, as mid-edge
// nodes of quadratic elements do.

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

// The nodes come first, in their order; tetrahedron t becomes 8 t to 8 t + 7.
TetMesh subdivided(const TetMesh& mesh);

}  // namespace forefeel
