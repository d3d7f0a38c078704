#pragma once
// What readers of surfaces collect (surface_file.cpp), and that of .ply. Private to this room.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/common/scanner.hpp"
#include "geometry/meshing/surface.hpp"

namespace forefeel {

inline constexpr std::int64_t most_corners = 10'000;  // of one polygon

// How a polygon was cut into triangles (polygon_cut_cgal.cpp).
struct PolygonCut {
  bool convex = true, crosses = false;
  double off_plane = 0;  // largest distance of a corner from the mean plane, over the polygon's size [1]
};
PolygonCut cut_polygon(std::span<const Vec3> nodes, std::span<const NodeIndex> polygon,
                       std::vector<Triangle>& to);

// Collects corners of one polygon after another. They are cut at the end, when all nodes are known.
struct SurfaceBuilder {
  Surface surface;
  std::vector<std::int64_t> polygon;  // being read
  std::vector<std::int64_t> corners;  // of all that are read
  std::vector<std::size_t> ends;      // of each, in `corners`
  std::vector<std::size_t> lines;     // of each, from 1; 0: in binary data

  void end_polygon(std::size_t line = 0) {
    // Some programs repeat a corner, or the first one at the end.
    polygon.erase(std::unique(polygon.begin(), polygon.end()), polygon.end());
    while (polygon.size() > 1 && polygon.back() == polygon.front()) polygon.pop_back();
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    ends.push_back(corners.size());
    lines.push_back(line);
    polygon.clear();
  }
};

// ASCII or binary of either byte order. InputError: file, line.
void read_ply(Scanner& in, SurfaceBuilder& out);

}  // namespace forefeel
