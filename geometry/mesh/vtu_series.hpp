#pragma once
// A body that moves, as files for ParaView: SERIES.pvd lists the times, one .vtu each holds the moved nodes
//   points        X + u [m], Float32: X position at rest in the mesh, u displacement
//   displacement  u [m], Float32, point data; X = point - u. The points are moved already: ParaView's Warp By Vector of
//                 displacement by -1 shows the body at rest, by k - 1 the motion k times as large
//   node          number of the node in the mesh, from 0
//   cells         triangles of the surface, outward, or all tetrahedra
//   TimeValue [s], tip [m]   field data: the time, and the position of the HIP from rest
// Arrays are appended raw, compressed by vtkZLibDataCompressor if the build has zlib; those that do not change
// are packed once. A .pvd may list several files for a time, as parts.

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

class VtuSeries {
 public:
  // nodes: those written, rising; they hold all nodes of the cells. surface: triangles, else tetrahedra.
  VtuSeries(const TetMesh& mesh, const std::vector<NodeIndex>& nodes, bool surface);
  // The content of one file. u: #nodes x 3, row by row [m].
  std::string frame(double t, const Vec3& tip, std::span<const float> u) const;

 private:
  std::vector<Eigen::Vector3f> rest_;
  std::size_t cells_ = 0;
  std::string node_, connectivity_, offsets_, types_;  // packed
};

struct SeriesFile {
  double t = 0;           // [s]
  int part = 0;           // number of the file among those of this time
  std::string file = "";  // relative to the .pvd
};

// The file appears complete or not at all.
void write_pvd(const std::filesystem::path& file, std::span<const SeriesFile> series);
std::vector<SeriesFile> read_pvd(const std::filesystem::path& file);  // InputError: none, or damaged

// Nodes and displacements of a file of a series. InputError for any other file.
struct MovedNodes {
  std::vector<NodeIndex> node;
  std::vector<Vec3> moved;  // [m]
};
MovedNodes read_moved_nodes(const std::filesystem::path& file);

}  // namespace forefeel
