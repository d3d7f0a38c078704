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

class CellRaster {
 public:
  // The block: voxels from low to below high. grain: rounding of the states' coordinates [m].
  CellRaster(VoxelLabels& voxels, const VoxelLimits& limits, const Voxel& low, const Voxel& high,
             double grain)
      : voxels_(voxels), limits_(limits), low_(low), high_(high), grain_(grain) {}

  // True if a voxel centre of the block may lie in the box around the corners.
  bool meets(const std::array<Vec3, 4>& corners);
  // After meets(corners). exact: no state lies in the cell's ball.
  void add(const std::array<Vec3, 4>& corners, bool exact);
  std::vector<std::size_t>& asked() { return asked_; }  // indices of the voxels marked ask or ask_cone

 private:
  void add_flat(const std::array<Vec3, 4>& corners);
  void add_row(std::int32_t j, std::int32_t k, double first, double last);
  std::uint8_t mark_at(const Vec3& q, const Thresholds& limits) const;
  void set(std::size_t index, std::uint8_t value);

  VoxelLabels& voxels_;
  const VoxelLimits& limits_;
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
