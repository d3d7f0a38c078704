#pragma once
// Divides the voxels of a box into blocks that hold about equally many states, by cuts at medians.

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/coverage/voxel_labels.hpp"

namespace forefeel {

struct CoverBlock {
  Voxel low{}, high{};                // voxels from low to below high
  std::uint32_t first = 0, last = 0;  // its states: order[first] to below order[last]
  Box extent;  // of these states [m]; those outside the box belong to the nearest voxel
  std::size_t states() const { return last - first; }
};

// order: indices of the states; reordered so that the states of a block follow each other.
std::vector<CoverBlock> cover_blocks(const VoxelGrid& grid, std::span<const Vec3> states,
                                     std::vector<std::uint32_t>& order);

}  // namespace forefeel
