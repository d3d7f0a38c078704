#pragma once
// Reads and writes tetrahedral meshes: Gmsh .msh 2.2 and 4.1 (ASCII and binary), legacy .vtk, .vtu, Medit
// .mesh. Nodes keep their order in the file and are numbered from 0. Errors are InputError and name file and
// line.

#include <filesystem>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

bool is_mesh_file(const std::filesystem::path& file);  // by extension: .msh .vtk .vtu .mesh

// The extension decides the format. Node groups: physical groups of Gmsh, of any dimension, keep their names
// (a group that holds the whole body is left out); references R of Medit become ref_vertices_R,
// ref_triangles_R, …. Does not check whether the mesh can be solved; check_and_orient() does.
TetMesh read_mesh(const std::filesystem::path& file);

// Gmsh 2.2 ASCII; groups become physical node groups. The file appears complete or not at all.
void write_msh(const std::filesystem::path& file, const TetMesh& mesh);

}  // namespace forefeel
