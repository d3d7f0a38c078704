#pragma once
// What readers of surfaces collect (surface_file.cpp), and that of .ply. Private to this room.

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
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
  std::int64_t first = 0;             // number of the first vertex in the file

  void end_polygon(std::size_t line = 0) {
    // Some programs repeat a corner, or the first one at the end.
    polygon.erase(std::unique(polygon.begin(), polygon.end()), polygon.end());
    while (polygon.size() > 1 && polygon.back() == polygon.front()) polygon.pop_back();
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    ends.push_back(corners.size());
    lines.push_back(line);
    polygon.clear();
  }

  // Text behind all that is announced, which may be of a count that is too small.
  void say_rest(Scanner& in, const char* last) {
    if (in.at_end()) return;
    in.token(last);
    const std::size_t line = in.where().line;
    std::size_t count = 0;
    for (std::string_view rest; in.line(rest) && !in.at_end();) ++count;
    surface.remarks.push_back("line " + std::to_string(line) + ": " + std::to_string(count + 1) +
                              (count == 0 ? " line" : " lines") + " behind " + last +
                              (count == 0 ? " is" : " are") +
                              " left out; is a count of the header too small?");
  }
};

// ASCII or binary of either byte order. InputError: file, line.
void read_ply(Scanner& in, SurfaceBuilder& out);

}  // namespace forefeel
