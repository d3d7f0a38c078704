#pragma once
// One small mesh in every format. It is written by independent code, so that all readers can be compared on
// it.

#include <map>
#include <string>

#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/meshing/surface.hpp"

namespace forefeel::test {

TetMesh sample_mesh();                                   // 3 tetrahedra on 6 nodes, group "held" = {0, 2}
std::map<std::string, std::string> sample_mesh_files();  // name ("gmsh41_binary.msh") -> content
Surface unit_cube();                                     // 12 triangles, outward, low corner at the origin
std::map<std::string, std::string> surface_files(const Surface& surface);

}  // namespace forefeel::test
