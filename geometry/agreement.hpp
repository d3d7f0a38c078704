#pragma once
// Where the octree index and the Delaunay triangulation label the same place differently, by volume.
//   share = (volume where both agree, blank left out) / (volume that is not blank for both)

#include <array>

#include "geometry/octree_index.hpp"
#include "geometry/state_space.hpp"

namespace forefeel {

struct Agreement {
  // volume[d][o]: the triangulation says label d, the octree says label o [m^3]
  std::array<std::array<double, 4>, 4> volume{};
  double share = 1;
  // The place in the middle of the longest run of samples that differ, and both labels there.
  Vec3 worst = Vec3::Zero();
  Label worst_delaunay = Label::blank, worst_octree = Label::blank;
};

// Sampled at the centres of cubes of side `step` [m] over the box.
Agreement compare_indexes(const StateSpace& space, const OctreeIndex& octree, const Box& box, double step);

}  // namespace forefeel
