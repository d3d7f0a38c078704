#pragma once
// Tetrahedral mesh in its rest shape: positions X_a [m], tetrahedra (a, b, c, d) with
// V = det[X_b - X_a, X_c - X_a, X_d - X_a] / 6 > 0. Nodes are numbered from 0 in file order.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

using NodeIndex = std::uint32_t;
using TetIndex = std::uint32_t;  // position in TetMesh::tets
constexpr NodeIndex no_node = ~NodeIndex{0};
constexpr TetIndex no_tet = ~TetIndex{0};
using Tet = std::array<NodeIndex, 4>;
using Triangle = std::array<NodeIndex, 3>;  // counter-clockwise seen from outside

// Of second-order tetrahedra the corners are taken; their mid-edge nodes belong to no tetrahedron here.
struct SecondOrder {
  std::vector<NodeIndex> middle_nodes = {};  // sorted
  double bent = 0;  // largest distance of one from the middle of its edge, over the length of the edge
};

struct TetMesh {
  std::vector<Vec3> nodes;                               // #V, [m]
  std::vector<Tet> tets;                                 // #T, positively oriented
  std::map<std::string, std::vector<NodeIndex>> groups;  // named node sets of the file, sorted
  // Named sets of tetrahedra of the file, sorted; they may overlap.
  std::map<std::string, std::vector<TetIndex>> element_groups = {};
  SecondOrder second_order = {};  // of the file; empty for linear tetrahedra
};

struct MeshQuality {
  double volume = 0;  // [m^3]
  double min_dihedral_deg = 0;
  double max_dihedral_deg = 0;
  double min_tet_volume = 0;  // [m^3]
};

double tet_volume(const TetMesh& mesh, std::size_t tet);  // signed, [m^3]
MeshQuality mesh_quality(const TetMesh& mesh);
// A node that belongs to no tetrahedron is no part of the body: no extent, no part, no set below counts it.
std::vector<char> used_nodes(const TetMesh& mesh);  // 1 for a node of a tetrahedron, else 0
Box bounding_box(const TetMesh& mesh);
double longest_side(const TetMesh& mesh);            // of the bounding box, [m]
void scale_to_length(TetMesh& mesh, double length);  // about the origin, until the longest side is length [m]
std::vector<Triangle> boundary_triangles(const TetMesh& mesh);  // outward
std::vector<NodeIndex> surface_nodes(const TetMesh& mesh);      // sorted
// Number of the connected part of each node, from 0; -1 for a node that belongs to no tetrahedron.
std::vector<int> components(const TetMesh& mesh);
// Number of the part of each tetrahedron, from 0; parts hang together by faces.
std::vector<int> face_parts(const TetMesh& mesh);

struct MeshCheck {
  std::vector<std::string> warnings;  // e.g. "all tetrahedra were turned", "3 nodes belong to no tetrahedron"
};
// Checks that a mesh can be solved. InputError at `where`: no tetrahedra, index out of range, coordinates
// that are not finite, zero volume (|V| < 1e-14 L^3, L the longest side), overlapping tetrahedra. Tetrahedra of
// negative volume are turned; those with the same four nodes are united, and are in the element groups of both; nodes
// of no tetrahedron leave the groups. Warnings say so.
MeshCheck check_and_orient(TetMesh& mesh, const std::string& where);

// What a mesh is made of.
struct MeshSummary {
  std::size_t nodes = 0, elements = 0;
  MeshQuality quality;
  Box box;             // [m]
  int components = 0;  // connected parts
  std::size_t surface_nodes = 0, surface_triangles = 0;
  std::map<std::string, std::size_t> groups;  // name -> number of nodes
  struct Region {
    std::string name;
    std::size_t elements = 0;
    double volume = 0;  // [m^3]
  };
  std::vector<Region> regions = {};  // element groups
};

// The mesh has at least one tetrahedron.
MeshSummary summarise(const TetMesh& mesh);

// Node sets by geometry; sorted.
// share: of the extent along the axis, from its low end, in [0, 1]; nodes within 1e-9 of the extent above it count.
std::vector<NodeIndex> nodes_below(const TetMesh& mesh, Axis axis, double share);
NodeIndex nearest_surface_node(const TetMesh& mesh, const Vec3& point);
std::vector<NodeIndex> surface_nodes_within(const TetMesh& mesh, const Vec3& centre, double radius);

}  // namespace forefeel
