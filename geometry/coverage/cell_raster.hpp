#pragma once
// Marks the voxels of a block whose centres q lie in a Delaunay cell with corners v_i. Barycentric weights w_i are
// affine in q, so each row of voxels meets the cell in one interval, and
//   pi^2(q) = sum w_i |v_i - q|^2
// takes a few products for each voxel. A mark is set only if rounding cannot change it. Otherwise, or if the cell alone
// does not decide (coverage_query.hpp), the voxel is queried later.
//
//   safe     pi is within the limit, and all corners lie in reach of the cone but not at q: they enclose q
//   sparse   pi is beyond the limit in a cell whose ball is empty, and a corner is near
//   ask_cone pi is within the limit, but a corner is out of reach: safe if other states enclose q, else sparse
//   ask      needs a query
//   unset    in no cell; or beyond the limit with no corner near

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/coverage/coverage_query.hpp"
#include "geometry/coverage/voxels.hpp"

namespace forefeel {

// The thresholds at the centres of the voxels. On an adaptive lattice they follow h(q).
class VoxelLimits {
 public:
  VoxelLimits(const StateSpaceOptions& options, const VoxelLabels& voxels);

  const Thresholds& at(std::size_t voxel) const { return all_[level_.empty() ? 0 : level_[voxel]]; }
  const Thresholds& widest() const { return all_[0]; }
  // Of all voxels from low to below end; null where they differ.
  const Thresholds* over(const VoxelLabels& voxels, const Voxel& low, const Voxel& end) const;

 private:
  std::vector<Thresholds> all_;      // by level: at the coarsest spacing, half of it, a quarter, ...
  std::vector<std::uint8_t> level_;  // by voxel; empty where the spacing is the same everywhere
};

inline constexpr std::uint8_t unset_label = 0xff;

namespace mark {
constexpr std::uint8_t safe = 0, sparse = 1, ask_cone = 0x40, ask = 0x41, unset = unset_label;
}

// Cubes of voxels that a state is near enough to make safe: elsewhere delta > kappa_s h, and pi >= delta. In a wide box
// with few states, large cells lie in such empty cubes for the most part. A tree: each level has cubes of twice the
// side.
class NearCubes {
 public:
  static constexpr int finest = 3;  // 2^3 voxels
  NearCubes(std::span<const Vec3> states, const VoxelLabels& voxels, double reach);

  // Calls visit(low, width) for the finest near cubes that meet the voxels from first to below end and that keep(low,
  // width) does not refuse, nor any larger cube around them.
  template <class Keep, class Visit>
  void for_each(const Voxel& first, const Voxel& end, Keep&& keep, Visit&& visit) const {
    descend(static_cast<int>(levels_.size()) - 1, {}, first, end, keep, visit);
  }

 private:
  struct Level {
    std::array<std::int64_t, 3> count{};
    std::vector<std::uint8_t> near;
    std::size_t index(const Voxel& cube) const {
      return static_cast<std::size_t>((cube[2] * count[1] + cube[1]) * count[0] + cube[0]);
    }
  };
  template <class Keep, class Visit>
  void descend(int level, const Voxel& cube, const Voxel& first, const Voxel& end, Keep& keep,
               Visit& visit) const {
    if (!levels_[static_cast<std::size_t>(level)].near[levels_[static_cast<std::size_t>(level)].index(cube)])
      return;
    const std::int32_t width = 1 << (finest + level);
    const Voxel low{cube[0] * width, cube[1] * width, cube[2] * width};
    for (std::size_t a = 0; a < 3; ++a)
      if (low[a] >= end[a] || low[a] + width <= first[a]) return;
    if (!keep(low, width)) return;
    if (level == 0) return visit(low, width);
    const Level& below = levels_[static_cast<std::size_t>(level - 1)];
    for (int child = 0; child < 8; ++child) {
      const Voxel part{2 * cube[0] + (child & 1), 2 * cube[1] + (child >> 1 & 1), 2 * cube[2] + (child >> 2)};
      if (part[0] < below.count[0] && part[1] < below.count[1] && part[2] < below.count[2])
        descend(level - 1, part, first, end, keep, visit);
    }
  }
  std::vector<Level> levels_;  // the finest first; the last has one cube
};

class CellRaster {
 public:
  // The block: voxels from low to below high. grain: rounding of the states' coordinates [m].
  CellRaster(VoxelLabels& voxels, const VoxelLimits& limits, const NearCubes& near, const Voxel& low,
             const Voxel& high, double grain)
      : voxels_(voxels), limits_(limits), near_(near), low_(low), high_(high), grain_(grain) {}

  // True if a voxel centre of the block may lie in the box around the corners.
  bool meets(const std::array<Vec3, 4>& corners);
  // After meets(corners). exact: no state lies in the cell's ball.
  void add(const std::array<Vec3, 4>& corners, bool exact);
  std::vector<std::size_t>& asked() { return asked_; }  // indices of the voxels marked ask or ask_cone

 private:
  void add_flat(const std::array<Vec3, 4>& corners);
  void add_rows(const std::array<double, 4>& inverse, double slack);
  bool is_large() const;
  template <class Keep, class Add>
  void add_parts(Keep&& keep, Add&& add);
  void add_row(std::int32_t j, std::int32_t k, double first, double last);
  std::uint8_t mark_at(const Vec3& q, const Thresholds& limits) const;
  void set(std::size_t index, std::uint8_t value);

  VoxelLabels& voxels_;
  const VoxelLimits& limits_;
  const NearCubes& near_;
  Voxel low_, high_, first_{}, end_{};
  double grain_;
  struct Cell {
    std::array<Vec3, 4> corner, slope;  // w_i(q) = (1 for i = 0, else 0) + slope_i . (q - corner_0)
    double doubt = 0;                   // of pi^2 [m^2]
    bool exact = false;
  };
  Cell cell_;  // the current one
  std::vector<std::size_t> asked_;
};

}  // namespace forefeel
