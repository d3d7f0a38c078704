#pragma once
// Compares the labels of the octree index with those of the Delaunay triangulation, by volume:
//   share = (volume that both label alike, and not blank) / (volume that at least one of them does not label
//           blank)                                                                                       [1]

#include <array>
#include <optional>

#include "geometry/coverage/octree_index.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

struct Agreement {
  // volume[d][o]: the triangulation says label d, the octree says label o [m^3]
  ByLabel<ByLabel<double>> volume{};
  double share = 1;
  // The cube in the middle of the longest run of differing cubes along x, and its two labels.
  struct Difference {
    Vec3 at;  // [m]
    Label delaunay, octree;
  };
  std::optional<Difference> worst;  // nothing if no label differs
};

// Over the cubes of side h/4 that regions consist of (voxel_grid.hpp), so the volumes are those of the
// regions.
Agreement compare_indexes(const StateSpace& space, const OctreeIndex& octree);

}  // namespace forefeel
