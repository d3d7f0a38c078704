#pragma once
// What the readers behind read_surface() share.

#include <algorithm>
#include <cstdint>
#include <string_view>
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

std::vector<std::string_view> words_of(std::string_view line);  // between blanks

void read_ply(Scanner& in, SurfaceBuilder& out);
void read_polydata(Scanner in, SurfaceBuilder& out);  // legacy .vtk, DATASET POLYDATA
void read_vtp(Scanner in, SurfaceBuilder& out);       // XML

}  // namespace forefeel
