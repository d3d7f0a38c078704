#include "scheduling/policy/region_shares.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {
namespace {

constexpr double most_voxels = 5e5;

VoxelGrid voxels_of(const Box& box, double H) {
  for (double side = 0.25 * H;; side *= 2) {
    VoxelGrid grid(box, side);
    if (grid.count[0] * grid.count[1] * grid.count[2] <= most_voxels) return grid;
  }
}

double volume_of(const VoxelGrid& grid, const Voxel& voxel) {
  return grid.cube(voxel, 1).size().prod();
}

}  // namespace

RegionShares::RegionShares(const StateSpace& space, double H, const std::array<int, 3>& parts)
    : space_(space),
      H_(H),
      parts_(parts),
      limits_(space.options().coverage, H, space.options().merge_distance * space.options().spacing),
      grid_(voxels_of(space.options().box, H)),
      kept_(static_cast<std::size_t>(grid_.count[0] * grid_.count[1] * grid_.count[2])),
      is_due_(kept_.size()),
      volume_(static_cast<std::size_t>(parts[0]) * static_cast<std::size_t>(parts[1]) *
              static_cast<std::size_t>(parts[2])),
      shares_(volume_.size()) {
  for (std::size_t i = 0; i < kept_.size(); ++i)
    volume_[part_of(grid_.centre(voxel(i)))] += volume_of(grid_, voxel(i));
  for (ByLabel<double>& share : shares_) share[Label::blank] = 1;
}

std::size_t RegionShares::number(const Voxel& voxel) const {
  const auto at = [](double v) { return static_cast<std::size_t>(v); };
  return at(voxel[0]) + at(grid_.count[0]) * (at(voxel[1]) + at(grid_.count[1]) * at(voxel[2]));
}

Voxel RegionShares::voxel(std::size_t number) const {
  const auto nx = static_cast<std::size_t>(grid_.count[0]), ny = static_cast<std::size_t>(grid_.count[1]);
  return {static_cast<std::int32_t>(number % nx), static_cast<std::int32_t>(number / nx % ny),
          static_cast<std::int32_t>(number / nx / ny)};
}

std::size_t RegionShares::part_of(const Vec3& centre) const {
  std::size_t part = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int i = static_cast<int>(axis);
    const double size = grid_.box.size()[i], share = size > 0 ? (centre[i] - grid_.box.low[i]) / size : 0;
    const int along = std::clamp(static_cast<int>(std::floor(share * parts_[axis])), 0, parts_[axis] - 1);
    part = part * static_cast<std::size_t>(parts_[axis]) + static_cast<std::size_t>(along);
  }
  return part;
}

void RegionShares::learn(const Vec3& at) {
  const Vec3 reach = Vec3::Constant(8 * H_);
  const Voxel low = grid_.voxel_of(at - reach), high = grid_.voxel_of(at + reach);
  for (std::int32_t z = low[2]; z <= high[2]; ++z)
    for (std::int32_t y = low[1]; y <= high[1]; ++y)
      for (std::int32_t x = low[0]; x <= high[0]; ++x) {
        const std::size_t i = number({x, y, z});
        if (is_due_[i] || kept_[i].label == Label::safe) continue;
        if (!may_change(kept_[i], grid_.centre({x, y, z}), at, H_, limits_)) continue;
        is_due_[i] = true;
        due_.push_back(static_cast<std::uint32_t>(i));
      }
}

void RegionShares::update() {
  for (const std::uint32_t i : due_) {
    is_due_[i] = false;
    const Vec3 centre = grid_.centre(voxel(i));
    const KeptLabel now = forefeel::label_at(space_, centre, limits_);
    if (now.label != kept_[i].label) {
      const std::size_t part = part_of(centre);
      const double share = volume_of(grid_, voxel(i)) / volume_[part];
      shares_[part][kept_[i].label] -= share;
      shares_[part][now.label] += share;
    }
    kept_[i] = now;
  }
  due_.clear();
}

Label RegionShares::label_at(const Vec3& q) const {
  return kept_[number(grid_.voxel_of(q))].label;
}

}  // namespace forefeel
