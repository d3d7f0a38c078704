#pragma once
// Reads and writes tetrahedral meshes: Gmsh .msh 1 (ASCII), 2.2 and 4.1 (ASCII and binary), legacy .vtk, .vtu,
// Medit .mesh. Nodes keep their order in the file and are numbered from 0. Errors are InputError and name file and
// line.

#include <filesystem>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

// "; meshio convert FILE.inp MESH.vtk converts it", for an error about a format of another program; else empty.
std::string converter_for(const std::filesystem::path& file);
bool is_mesh_file(const std::filesystem::path& file);  // by extension: .msh .vtk .vtu .mesh

// The extension decides the format. Does not check whether the mesh can be solved; check_and_orient() does.
// Node groups come from physical groups of Gmsh of any dimension, under their names (a group of the whole body is
// left out); from references R of Medit, as ref_vertices_R, ref_triangles_R, …; and from arrays of 0 and 1 in the
// point data of .vtu. Element groups come from physical volumes of Gmsh and references of Medit's tetrahedra, named
// alike, and from labels in cell arrays of VTK (tissue_7, see add_label_groups()).
TetMesh read_mesh(const std::filesystem::path& file);

// Gmsh 2.2 ASCII. Node groups become physical points, element groups physical volumes; a tetrahedron of several
// element groups keeps only the first. The file appears complete or not at all.
void write_msh(const std::filesystem::path& file, const TetMesh& mesh);

// VTK XML, ASCII. Each node group is an array of point data and each element group one of cell data, with 1 for its
// members and 0 for others; read_mesh() makes the same groups of them. The file appears complete or not at all.
void write_vtu(const std::filesystem::path& file, const TetMesh& mesh);

// By extension: .msh or .vtu; InputError for others.
void write_mesh(const std::filesystem::path& file, const TetMesh& mesh);
bool is_written_mesh(const std::filesystem::path& file);  // by extension

}  // namespace forefeel
