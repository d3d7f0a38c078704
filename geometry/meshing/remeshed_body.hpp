#pragma once
// A volume mesh made anew from its boundary, finer or graded toward a contact, with its groups. Edges of the new mesh
// run along the borders of groups of surface nodes: the triangles whose three nodes are in a group keep their union.

#include "geometry/meshing/tetrahedralise.hpp"

namespace forefeel {

// options: as of tetrahedralise(), without rim, marks and pins; elements above 0. InputError at options.name where a
// group cannot be kept: nodes inside the body, mostly nodes in lines on the surface, tetrahedra that are a part of
// the body.
TetMesh remeshed(const TetMesh& mesh, TetrahedraliseOptions options, TetrahedraliseReport* report = nullptr);

}  // namespace forefeel
