#pragma once
// What a tetrahedral mesh is made of: counts, volume, quality, extent.

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

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

}  // namespace forefeel
