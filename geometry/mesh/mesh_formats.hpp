#pragma once
// The readers behind read_mesh(), one for each format. The scanner holds the whole file.

#include <cstdint>
#include <set>
#include <span>
#include <string>

#include "geometry/common/scanner.hpp"
#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

TetMesh read_gmsh(Scanner in);        // .msh 1 (ASCII), 2.2 and 4.1 (ASCII and binary)
TetMesh read_vtk_legacy(Scanner in);  // .vtk, DATASET UNSTRUCTURED_GRID, ASCII and BINARY
TetMesh read_vtu(Scanner in);         // .vtu: ascii, binary or appended data; zlib if the build has it
TetMesh read_medit(Scanner in);       // .mesh

// Adds a second-order tetrahedron; middle: its nodes on the edges 01, 12, 02, 03, 13, 23.
void add_second_order(TetMesh& mesh, const Tet& corners, const std::array<NodeIndex, 6>& middle);
// "; mesh the body with tetrahedra …": what to do with other volume elements.
extern const char* const not_tetrahedra;

// Adds a tetrahedron; ignores points, lines and faces; InputError for other cells. where: name of the file.
void add_vtk_cell(TetMesh& mesh, std::int64_t type, std::span<const std::int64_t> nodes,
                  const std::string& where);

// One value of a cell array, at a tetrahedron.
struct CellLabel {
  TetIndex tet = 0;
  double value = 0;
};
// Makes element groups from a cell array NAME that labels the tetrahedra by whole numbers, at most 256 different ones:
// the group NAME_7 holds the tetrahedra with 7, and so on. If all values are 0 or 1, there is also a group NAME, which
// holds those with 1. Other arrays are ignored.
void add_label_groups(TetMesh& mesh, const std::string& array, std::span<const CellLabel> labels);

// Sorts every group, removes duplicates and empty groups.
void tidy_groups(TetMesh& mesh);

}  // namespace forefeel
