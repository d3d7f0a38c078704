#pragma once
// Labels of all voxels of a box (voxel_grid.hpp): one byte a voxel, x fastest.

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/coverage/coverage.hpp"
#include "geometry/coverage/voxel_grid.hpp"

namespace forefeel {

struct VoxelLabels {
  VoxelGrid grid;
  std::array<std::int64_t, 3> count{};           // voxels along each axis
  std::array<std::vector<double>, 3> centre;     // of the voxels along each axis [m]
  std::array<std::vector<double>, 3> low, high;  // their faces, clipped to the box [m]
  std::vector<std::uint8_t> label;

  VoxelLabels(const Box& box, double voxel, std::uint8_t start) : grid(box, voxel) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      count[axis] = static_cast<std::int64_t>(grid.count[axis]);
      for (std::int32_t i = 0; i < count[axis]; ++i) {
        Voxel at{};
        at[axis] = i;
        const Box cube = grid.cube(at, 1);
        const auto a = static_cast<Eigen::Index>(axis);
        centre[axis].push_back(grid.centre(at)[a]);
        low[axis].push_back(cube.low[a]);
        high[axis].push_back(cube.high[a]);
      }
    }
    label.assign(static_cast<std::size_t>(count[0] * count[1] * count[2]), start);
  }
  std::size_t index(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::size_t>((k * count[1] + j) * count[0] + i);
  }
  Voxel voxel(std::size_t index) const {
    const auto i = static_cast<std::int64_t>(index), row = i / count[0];
    return {static_cast<std::int32_t>(i % count[0]), static_cast<std::int32_t>(row % count[1]),
            static_cast<std::int32_t>(row / count[1])};
  }
  // The cube of `width` voxels with its low corner at `from`, as far as it lies in the box.
  void fill(const Voxel& from, std::int32_t width, std::uint8_t value) {
    std::array<std::int64_t, 3> end{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      end[axis] = std::min<std::int64_t>(from[axis] + width, count[axis]);
    for (std::int64_t k = from[2]; k < end[2]; ++k)
      for (std::int64_t j = from[1]; j < end[1]; ++j) {
        std::uint8_t* const row = label.data() + index(0, j, k);
        std::fill(row + from[0], row + end[0], value);
      }
  }
  Vec3 centre_of(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return {centre[0][static_cast<std::size_t>(i)], centre[1][static_cast<std::size_t>(j)],
            centre[2][static_cast<std::size_t>(k)]};
  }
};

}  // namespace forefeel
