#pragma once
// The runs of equal labels along the rows of voxels, and their components: runs of one label that are connected over
// shared facets. 8 bytes a run.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "geometry/coverage/voxels.hpp"

namespace forefeel {

class VoxelRuns {
 public:
  explicit VoxelRuns(const VoxelLabels& voxels);

  std::size_t rows() const { return row_.size() - 1; }  // row = k * count[1] + j
  std::uint32_t first_run(std::size_t row) const { return row_[row]; }
  std::uint32_t end_run(std::size_t row) const { return row_[row + 1]; }
  std::int32_t start(std::uint32_t run) const { return start_[run]; }  // voxel along x
  std::int32_t end(std::size_t row, std::uint32_t run) const {
    return run + 1 < row_[row + 1] ? start_[run + 1] : width_;
  }
  std::uint32_t component(std::uint32_t run) const { return component_[run]; }
  std::size_t components() const { return components_; }
  std::uint32_t run_at(std::size_t row, std::int32_t i) const {
    const auto begin = start_.begin();
    return static_cast<std::uint32_t>(std::upper_bound(begin + row_[row], begin + row_[row + 1], i) - begin -
                                      1);
  }

  // visit(run of row a, run of row b, first common voxel) for runs that overlap.
  template <class Visit>
  void for_each_overlap(std::size_t a, std::size_t b, Visit&& visit) const {
    std::uint32_t ra = row_[a], rb = row_[b];
    std::int32_t i = 0;
    while (i < width_) {
      visit(ra, rb, i);
      const std::int32_t ea = end(a, ra), eb = end(b, rb);
      i = std::min(ea, eb);
      if (ea == i) ++ra;
      if (eb == i) ++rb;
    }
  }

 private:
  void find_runs(const VoxelLabels& voxels);
  void connect(const VoxelLabels& voxels);
  std::uint32_t root(std::uint32_t run);
  void join(const VoxelLabels& voxels, std::size_t a, std::size_t b);

  std::int32_t width_;
  std::vector<std::uint32_t> row_;  // first run of each row, and the number of runs
  std::vector<std::int32_t> start_;
  std::vector<std::uint32_t> component_;  // while connecting: a run of the same component, not after it
  std::size_t components_ = 0;
};

}  // namespace forefeel
