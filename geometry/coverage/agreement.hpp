#pragma once
// Where the octree index and the Delaunay triangulation label the same place differently, by volume.
//   share = (volume where both agree, blank left out) / (volume that is not blank for both)

#include <array>
#include <optional>

#include "geometry/coverage/octree_index.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

struct Agreement {
  // volume[d][o]: the triangulation says label d, the octree says label o [m^3]
  std::array<std::array<double, 4>, 4> volume{};
  double share = 1;
  // The cube in the middle of the longest run of cubes along x that differ, and both its labels.
  struct Difference {
    Vec3 at;
    Label delaunay, octree;
  };
  std::optional<Difference> worst;  // none where nothing differs
};

// By the cubes of h/4 that the regions of the space are made of (voxel_grid.hpp): the volumes are those of both regions.
Agreement compare_indexes(const StateSpace& space, const OctreeIndex& octree);

}  // namespace forefeel
