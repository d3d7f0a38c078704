#pragma once
// The regions of a body's picture: its materials, or the groups of tetrahedra of a mesh.

#include "apps/show/show_content.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// Fills the regions of a shown body, whose mesh and surface are there. Positions are still those of the mesh.
void take_regions(const Body& body, ShownBody& shown);
// A tetrahedron in several groups counts for the first by name. One group of all tetrahedra is no region.
void take_regions(const TetMesh& mesh, ShownBody& shown);

}  // namespace forefeel
