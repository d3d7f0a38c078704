#pragma once
// Coverage of a box by a fixed set of states: the labels of all voxels of side h/4 (regions.hpp), computed block by
// block. The labels are those of Regions, but no triangulation is kept and no state can be added: each block is
// triangulated with the states around it, labelled, and its triangulation dropped (block_cover.hpp). All threads work
// at once; the results do not depend on their number.
// Memory: 80 bytes a state, 1 byte a voxel, 8 bytes for each run of equal labels along x while components are
// found, and for each thread the triangulation of a block (up to 60 thousand states and those around them).

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/coverage/region_summary.hpp"
#include "geometry/coverage/state_space_options.hpp"

namespace forefeel {

class CoverageMap {
 public:
  // options.lattice must be null. States nearer than the merge distance to an earlier one are ignored. One thread calls
  // progress with the share done.
  CoverageMap(std::vector<Vec3> states, const StateSpaceOptions& options,
              const std::function<void(double)>& progress = {});
  ~CoverageMap();

  Label label_at(const Vec3& q) const;            // of the voxel that holds q, a place of the box
  RegionSummary summary(bool with_leaves) const;  // without them, `leaves` is empty
  double fill_distance() const;                   // [m]; at most 1e-3 h too small; infinite without states
  std::optional<EmptyBall> largest_hole() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
