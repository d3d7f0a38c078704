#pragma once
// The readers behind read_mesh(), one for each format. The scanner holds the whole file.

#include <cstdint>
#include <set>
#include <span>
#include <string>

#include "geometry/common/scanner.hpp"
#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

TetMesh read_gmsh(Scanner in);        // .msh 2.2 and 4.1, ASCII and binary
TetMesh read_vtk_legacy(Scanner in);  // .vtk, DATASET UNSTRUCTURED_GRID, ASCII and BINARY
TetMesh read_vtu(Scanner in);         // .vtu: ascii, binary or appended data; zlib if the build has it
TetMesh read_medit(Scanner in);       // .mesh

// Adds a tetrahedron; ignores points, lines and faces; InputError for other cells. where: name of the file.
void add_vtk_cell(TetMesh& mesh, std::int64_t type, std::span<const std::int64_t> nodes,
                  const std::string& where);

// Sorts every group, removes duplicate nodes and empty groups.
void tidy_groups(TetMesh& mesh);

}  // namespace forefeel
