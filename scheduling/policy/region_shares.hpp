#pragma once
// How much of each part of a box is safe, sparse, gap and blank, at one spacing H, kept up to date while states come:
// the volumes of the regions (regions.hpp), of voxels of side H/4 with the label of their centre. The box is divided
// into equal parts. Above half a million voxels their side is doubled until there are fewer.

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/coverage/voxels.hpp"
#include "scheduling/policy/kept_label.hpp"

namespace forefeel {

class RegionShares {
 public:
  // Everything is blank until states are learnt. parts: along each axis, the last axis fastest. The space must outlive
  // this.
  RegionShares(const StateSpace& space, double H, const std::array<int, 3>& parts);

  void learn(const Vec3& at);  // a state of the space, new [m]
  void update();               // labels what the learnt states may have changed

  Label label_at(const Vec3& q) const;  // of the voxel that holds q, a place of the box
  // Shares of the volume of a part, sum 1.
  const ByLabel<double>& share(std::size_t part) const { return shares_[part]; }

 private:
  std::size_t number(const Voxel& voxel) const;
  Voxel voxel(std::size_t number) const;
  std::size_t part_of(const Vec3& centre) const;

  const StateSpace& space_;
  double H_;
  std::array<int, 3> parts_;
  Thresholds limits_;
  VoxelGrid grid_;
  std::vector<KeptLabel> kept_;          // by voxel
  std::vector<std::uint32_t> due_;       // voxels whose label may have changed
  std::vector<bool> is_due_;             // by voxel
  std::vector<double> volume_;           // of parts: of their voxels [m^3]
  std::vector<ByLabel<double>> shares_;  // by part
};

}  // namespace forefeel
