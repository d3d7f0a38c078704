#pragma once
// Reading and writing tetrahedral meshes: Gmsh .msh 2.2 and 4.1 (ASCII and binary), legacy .vtk and .vtu, Medit .mesh.
// Nodes keep their order in the file, counted from 0. Errors: InputError naming file and line.

#include <filesystem>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

bool is_mesh_file(const std::filesystem::path& file);  // by extension: .msh .vtk .vtu .mesh

// Reads by extension. Physical groups of Gmsh become groups by name (of any dimension; one that holds the whole body is
// left out), references of Medit ref_vertices_R, ref_triangles_R, …. Does not check quality (see check_and_orient).
TetMesh read_mesh(const std::filesystem::path& file);

// Gmsh 2.2 ASCII, written to a temporary name and renamed; groups become physical node groups.
void write_msh(const std::filesystem::path& file, const TetMesh& mesh);

}  // namespace forefeel
