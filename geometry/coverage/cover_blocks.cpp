#include "geometry/coverage/cover_blocks.hpp"

#include <algorithm>

namespace forefeel {
namespace {

constexpr std::size_t most_states = 60'000;
constexpr std::int64_t most_voxels = std::int64_t{1} << 25;

class Division {
 public:
  Division(const VoxelGrid& grid, std::span<const Vec3> states, std::vector<std::uint32_t>& order)
      : grid_(grid), states_(states), order_(order) {}

  void divide(CoverBlock block) {
    std::array<std::size_t, 3> axes{0, 1, 2};
    const auto width = [&](std::size_t axis) { return block.high[axis] - block.low[axis]; };
    std::ranges::sort(axes, std::greater(), width);
    const bool many = block.states() > most_states;
    const bool large = std::int64_t{width(0)} * width(1) * width(2) > most_voxels;
    if ((!many && !large) || width(axes[0]) == 1) return keep(block);
    const std::size_t axis = axes[0];
    const std::int32_t cut = many ? median(block, axis) : block.low[axis] + width(axis) / 2;
    const auto begin = order_.begin();
    const auto middle = std::stable_partition(begin + block.first, begin + block.last,
                                              [&](std::uint32_t i) { return voxel(i, axis) < cut; });
    CoverBlock upper = block;
    block.high[axis] = upper.low[axis] = cut;
    block.last = upper.first = static_cast<std::uint32_t>(middle - begin);
    divide(block);
    divide(upper);
  }
  std::vector<CoverBlock> blocks;

 private:
  std::int32_t voxel(std::uint32_t state, std::size_t axis) const {
    return grid_.voxel_of(states_[state])[axis];
  }
  // Between the first and the last voxel.
  std::int32_t median(const CoverBlock& block, std::size_t axis) {
    std::vector<std::int32_t> at;
    const std::size_t step = 1 + block.states() / 4096;
    for (std::size_t i = block.first; i < block.last; i += step) at.push_back(voxel(order_[i], axis));
    const auto middle = at.begin() + static_cast<std::ptrdiff_t>(at.size() / 2);
    std::ranges::nth_element(at, middle);
    return std::clamp(*middle, block.low[axis] + 1, block.high[axis] - 1);
  }
  void keep(CoverBlock& block) {
    for (std::size_t i = block.first; i < block.last; ++i) {
      const Vec3& at = states_[order_[i]];
      if (i == block.first) block.extent = {at, at};
      block.extent = {block.extent.low.cwiseMin(at), block.extent.high.cwiseMax(at)};
    }
    blocks.push_back(block);
  }

  const VoxelGrid& grid_;
  std::span<const Vec3> states_;
  std::vector<std::uint32_t>& order_;
};

}  // namespace

std::vector<CoverBlock> cover_blocks(const VoxelGrid& grid, std::span<const Vec3> states,
                                     std::vector<std::uint32_t>& order) {
  CoverBlock whole;
  whole.last = static_cast<std::uint32_t>(order.size());
  for (std::size_t axis = 0; axis < 3; ++axis) whole.high[axis] = static_cast<std::int32_t>(grid.count[axis]);
  Division division(grid, states, order);
  division.divide(whole);
  return std::move(division.blocks);
}

}  // namespace forefeel
