#pragma once
// A box divided into cubes (voxels) of side h/4, the finest cells of regions, and the label of each.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "geometry/coverage/coverage.hpp"

namespace forefeel {

using Voxel = std::array<std::int32_t, 3>;

// The grid is centred in the box. If the box is not a multiple of the side, cubes at its faces are cut off; the centre
// of such a voxel is the centre of its remaining part.
struct VoxelGrid {
  Box box;                        // [m]
  double side = 0;                // [m]
  std::array<double, 3> count{};  // voxels along each axis; whole, as double since an int may overflow
  Vec3 origin = Vec3::Zero();     // low corner of voxel (0, 0, 0) [m]

  VoxelGrid(const Box& around, double voxel) : box(around), side(voxel) {
    for (unsigned axis = 0; axis < 3; ++axis)
      count[axis] = std::max(1.0, std::ceil(box.size()[axis] / side - 1e-6));
    origin = box.centre() - 0.5 * side * Vec3(count[0], count[1], count[2]);
  }

  Vec3 low_of(const Voxel& voxel) const { return origin + side * Vec3(voxel[0], voxel[1], voxel[2]); }
  // The voxel that contains a place of the box.
  Voxel voxel_of(const Vec3& q) const {
    Voxel voxel{};
    for (unsigned axis = 0; axis < 3; ++axis) {
      const auto a = axis;
      const double last = std::min(count[axis] - 1, 2147483647.0);
      voxel[axis] = static_cast<std::int32_t>(std::clamp(std::floor((q[a] - origin[a]) / side), 0.0, last));
    }
    return voxel;
  }
  // The cube of `width` voxels with its low corner at voxel `low`, cut off at the box.
  Box cube(const Voxel& low, double width) const {
    const Vec3 corner = low_of(low);
    return {corner.cwiseMax(box.low).cwiseMin(box.high),
            (corner + Vec3::Constant(side * width)).cwiseMin(box.high).cwiseMax(box.low)};
  }
  // The middle of the part of a voxel that lies in the box.
  Vec3 centre(const Voxel& voxel) const {
    const Vec3 low = low_of(voxel);
    const Vec3 below = (box.low - low).cwiseMax(0.0),
               above = (low + Vec3::Constant(side) - box.high).cwiseMax(0.0);
    const auto cut = [&](double d) { return d > 1e-6 * side ? d : 0.0; };
    Vec3 middle = low + Vec3::Constant(0.5 * side);
    for (int axis = 0; axis < 3; ++axis) middle[axis] += 0.5 * (cut(below[axis]) - cut(above[axis]));
    return middle;
  }
  // The middle of a cube of `width` voxels, and how far from it the centres of its voxels lie at most. A voxel that the
  // box cuts off has its centre up to half a voxel from the middle of the whole voxel, per axis.
  Vec3 middle(const Voxel& low, std::int32_t width) const {
    return width == 1 ? centre(low) : Vec3(low_of(low) + Vec3::Constant(0.5 * side * width));
  }
  double reach(const Voxel& low, std::int32_t width) const {
    const double whole = 0.5 * (width - 1) * side * std::numbers::sqrt3;
    if (width == 1) return whole;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (low[axis] == 0 || low[axis] + width >= count[axis]) return whole + 0.5 * side * std::numbers::sqrt3;
    return whole;
  }
};

// The cubes of 2^level voxels that cover a grid: of 32 voxels, or larger where there would be more than two million.
struct RootCubes {
  int level = 5;
  std::array<std::int32_t, 3> count{};

  explicit RootCubes(const VoxelGrid& grid) {
    for (;; ++level) {
      double all = 1;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        count[axis] =
            ((static_cast<std::int32_t>(std::min(grid.count[axis], 2147483647.0)) - 1) >> level) + 1;
        all *= static_cast<double>(count[axis]);
      }
      if (all <= 1u << 21) return;
    }
  }
  std::int32_t size() const { return count[0] * count[1] * count[2]; }
  Voxel low(std::int32_t root) const {
    return {(root % count[0]) << level, (root / count[0] % count[1]) << level,
            (root / count[0] / count[1]) << level};
  }
  std::int32_t root_of(const Voxel& v) const {
    return ((v[2] >> level) * count[1] + (v[1] >> level)) * count[0] + (v[0] >> level);
  }
};

// One byte a voxel, x fastest.
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
