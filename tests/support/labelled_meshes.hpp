#pragma once
// A mesh of two tetrahedra and a triangle with labels, in every format that has them.

#include <map>
#include <string>

namespace forefeel::test {

// Two tetrahedra that share a face, and one of its faces as a triangle.
inline const char* const labelled_gmsh1 = R"($NOD
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
9 1 1 1
$ENDNOD
$ELM
3
1 2 5 1 3 1 2 3
2 4 7 2 4 1 2 3 4
3 4 8 2 4 2 3 4 9
$ENDELM
)";

inline const char* const labelled_gmsh22 = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
3 7 "liver"
3 8 "a tumour"
$EndPhysicalNames
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
9 1 1 1
$EndNodes
$Elements
3
1 2 2 5 1 1 2 3
2 4 2 7 2 1 2 3 4
3 4 2 8 2 2 3 4 9
$EndElements
)";

// Both volumes are of the group "all", the second also of "a tumour".
inline const char* const labelled_gmsh41 = R"($MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
3 7 "all"
3 8 "a tumour"
$EndPhysicalNames
$Entities
0 0 0 2
1 0 0 0 1 1 1 1 7 0
2 0 0 0 1 1 1 2 7 8 0
$EndEntities
$Nodes
1 5 1 9
3 1 0 5
1
2
3
4
9
0 0 0
1 0 0
0 1 0
0 0 1
1 1 1
$EndNodes
$Elements
2 2 1 2
3 1 4 1
1 1 2 3 4
3 2 4 1
2 2 3 4 9
$EndElements
)";

inline const char* const labelled_medit = R"(MeshVersionFormatted 2
Dimension 3
Vertices 5
0 0 0 0
1 0 0 0
0 1 0 0
0 0 1 0
1 1 1 0
Tetrahedra 2
1 2 3 4 0
2 3 4 5 3
End
)";

inline const char* const labelled_legacy = R"(# vtk DataFile Version 3.0
labels
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 5 double
0 0 0 1 0 0 0 1 0 0 0 1 1 1 1
CELLS 3 14
3 0 1 2
4 0 1 2 3
4 1 2 3 4
CELL_TYPES 3
5
10
10
POINT_DATA 5
SCALARS temperature float 1
LOOKUP_TABLE default
1.5 2 3 4 5
VECTORS motion double
0 0 0 0 0 0 0 0 0 0 0 0 0 0 0
CELL_DATA 3
SCALARS tissue int 1
LOOKUP_TABLE default
9 4 -2
FIELD more 3
tumour 1 3 int
7 0 1
stress 1 3 double
0.5 0.25 0.5
frame 2 3 int
1 2 3 4 5 6
)";

inline const char* const labelled_vtu =
    R"(<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="5" NumberOfCells="3">
<CellData Scalars="tissue">
<DataArray type="Float64" Name="tissue" format="ascii">9 4 -2</DataArray>
<DataArray type="UInt8" Name="tumour" format="ascii">7 0 1</DataArray>
<DataArray type="Float64" Name="stress" format="ascii">0.5 0.25 0.5</DataArray>
<DataArray type="Int32" Name="frame" NumberOfComponents="2" format="ascii">1 2 3 4 5 6</DataArray>
<Array type="String" Name="words" format="ascii">65 0 66 0 67 0</Array>
</CellData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1 1 1 1</DataArray></Points>
<Cells>
<DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 0 1 2 3 1 2 3 4</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">3 7 11</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">5 10 10</DataArray>
</Cells></Piece></UnstructuredGrid></VTKFile>
)";

inline std::map<std::string, std::string> labelled_mesh_files() {
  return {{"1.msh", labelled_gmsh1},  {"22.msh", labelled_gmsh22}, {"41.msh", labelled_gmsh41},
          {"m.mesh", labelled_medit}, {"l.vtk", labelled_legacy},  {"x.vtu", labelled_vtu}};
}

}  // namespace forefeel::test
