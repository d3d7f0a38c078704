#pragma once
// What readers of surfaces collect (surface_file.cpp), and that of .ply. Private to this room.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "geometry/common/scanner.hpp"
#include "geometry/meshing/surface.hpp"

namespace forefeel {

inline constexpr std::int64_t most_corners = 10'000;  // of one polygon

// Collects corners of one polygon after another; indices are checked at the end, when all nodes are known.
struct SurfaceBuilder {
  Surface surface;
  std::vector<std::int64_t> polygon;
  std::int64_t greatest = -1;

  void end_polygon() {
    for (const std::int64_t node : polygon) greatest = std::max(greatest, node);
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k)
      surface.triangles.push_back({static_cast<NodeIndex>(polygon[0]), static_cast<NodeIndex>(polygon[k]),
                                   static_cast<NodeIndex>(polygon[k + 1])});
    polygon.clear();
  }
};

// ASCII or binary of either byte order. InputError: file, line.
void read_ply(Scanner& in, SurfaceBuilder& out);

}  // namespace forefeel
