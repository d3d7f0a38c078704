#pragma once
// Legacy .vtk files, DATASET UNSTRUCTURED_GRID or POLYDATA: versions up to 4.2 (CELLS n size) and 5.1 (OFFSETS,
// CONNECTIVITY), ASCII and BINARY (big-endian). Errors are InputError and name file and line.

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "geometry/common/scanner.hpp"
#include "geometry/common/types.hpp"

namespace forefeel {

struct VtkCells {
  std::vector<std::size_t> offsets{0};     // cell i has the points offsets[i] to offsets[i + 1] - 1
  std::vector<std::int64_t> connectivity;  // numbers of points, not checked
  std::size_t size() const { return offsets.size() - 1; }
};

struct VtkLegacyFile {
  bool polydata = false;
  std::vector<Vec3> points;
  std::map<std::string, VtkCells> cells;                   // "cells"; "polygons", "triangle_strips", …
  std::vector<std::int64_t> types;                         // of "cells"
  std::map<std::string, std::vector<double>> cell_arrays;  // of one component, by name
};

// Reads to the end, or up to the first attribute of an unknown kind.
VtkLegacyFile read_vtk_file(Scanner in);

}  // namespace forefeel
