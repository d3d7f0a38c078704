#include "geometry/coverage/region_sampling.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "geometry/common/error.hpp"
#include "geometry/common/union_find.hpp"
#include "geometry/coverage/bridge.hpp"
#include "geometry/coverage/voxel_grid.hpp"

namespace forefeel {
namespace {

struct Voxels {
  VoxelGrid grid;
  std::array<std::int64_t, 3> count{};
  std::vector<Label> label;

  std::int64_t index(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return (k * count[1] + j) * count[0] + i;
  }
  static std::array<std::int32_t, 3> voxel(std::int64_t i, std::int64_t j, std::int64_t k) {
    return {static_cast<std::int32_t>(i), static_cast<std::int32_t>(j), static_cast<std::int32_t>(k)};
  }
  Box box_of(std::int64_t i, std::int64_t j, std::int64_t k, std::int64_t width) const {
    return grid.cube(voxel(i, j, k), static_cast<double>(width));
  }
};

Voxels label_voxels(const Box& box, double spacing, const std::function<Label(const Vec3&)>& label) {
  Voxels voxels{VoxelGrid(box, spacing / 4), {}, {}};
  double total = 1;
  for (const double n : voxels.grid.count) total *= n;
  if (!(total <= 4e8))
    throw InputError("box", "holds more than 4e8 voxels of h/4, expected a smaller box or a larger spacing");
  for (std::size_t axis = 0; axis < 3; ++axis)
    voxels.count[axis] = static_cast<std::int64_t>(voxels.grid.count[axis]);
  const auto& n = voxels.count;
  voxels.label.resize(static_cast<std::size_t>(total));
#pragma omp parallel for schedule(dynamic)
  for (std::int64_t k = 0; k < n[2]; ++k)
    for (std::int64_t j = 0; j < n[1]; ++j)
      for (std::int64_t i = 0; i < n[0]; ++i)
        voxels.label[static_cast<std::size_t>(voxels.index(i, j, k))] =
            label(voxels.grid.centre(Voxels::voxel(i, j, k)));
  return voxels;
}

// Offsets to all voxels whose cube is within `rim` of the cube of a voxel.
std::vector<std::array<std::int64_t, 3>> steps_within(double rim, double side) {
  std::vector<std::array<std::int64_t, 3>> steps;
  const auto most = static_cast<std::int64_t>(std::floor(rim / side)) + 1;
  const auto apart = [&](std::int64_t d) {
    return side * static_cast<double>(std::max<std::int64_t>(0, std::abs(d) - 1));
  };
  for (std::int64_t k = -most; k <= most; ++k)
    for (std::int64_t j = -most; j <= most; ++j)
      for (std::int64_t i = -most; i <= most; ++i)
        if (Vec3(apart(i), apart(j), apart(k)).squaredNorm() <= rim * rim) steps.push_back({i, j, k});
  return steps;
}

void find_safe_neighbours(const Voxels& voxels, const std::vector<std::uint32_t>& component, double rim,
                          RegionSummary& result) {
  const auto& n = voxels.count;
  const std::array<std::int64_t, 3> step{1, n[0], n[0] * n[1]};
  std::vector<std::set<std::uint32_t>> beside(result.components.size()), near_safe(result.components.size());
  std::vector<bool> edge(voxels.label.size());
  const auto for_each = [&](auto&& visit) {
    for (std::int64_t k = 0; k < n[2]; ++k)
      for (std::int64_t j = 0; j < n[1]; ++j)
        for (std::int64_t i = 0; i < n[0]; ++i)
          visit(std::array{i, j, k}, static_cast<std::size_t>(voxels.index(i, j, k)));
  };
  for_each([&](const std::array<std::int64_t, 3>& at, std::size_t here) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (at[axis] + 1 >= n[axis]) continue;
      const std::size_t next = here + static_cast<std::size_t>(step[axis]);
      const std::uint32_t a = component[here], b = component[next];
      if (a != b) beside[a].insert(b), beside[b].insert(a), edge[here] = edge[next] = true;
    }
  });
  const std::vector<std::array<std::int64_t, 3>> steps = steps_within(rim, voxels.grid.side);
  for_each([&](const std::array<std::int64_t, 3>& at, std::size_t here) {
    if (voxels.label[here] != Label::gap || !edge[here]) return;
    for (const auto& d : steps) {
      const std::int64_t i = at[0] + d[0], j = at[1] + d[1], k = at[2] + d[2];
      if (i < 0 || j < 0 || k < 0 || i >= n[0] || j >= n[1] || k >= n[2]) continue;
      const auto there = static_cast<std::size_t>(voxels.index(i, j, k));
      if (voxels.label[there] == Label::safe) near_safe[component[here]].insert(component[there]);
    }
  });
  name_safe_neighbours(beside, near_safe, result.components);
}

// Component of each voxel; components are numbered by label, then by falling volume.
std::vector<std::uint32_t> components_of(const Voxels& voxels, double rim, RegionSummary& result) {
  const auto& n = voxels.count;
  UnionFind sets(voxels.label.size());
  const std::array<std::int64_t, 3> step{1, n[0], n[0] * n[1]};
  const auto for_each = [&](auto&& visit) {
    for (std::int64_t k = 0; k < n[2]; ++k)
      for (std::int64_t j = 0; j < n[1]; ++j)
        for (std::int64_t i = 0; i < n[0]; ++i)
          visit(i, j, k, static_cast<std::uint32_t>(voxels.index(i, j, k)));
  };
  for_each([&](std::int64_t i, std::int64_t j, std::int64_t k, std::uint32_t here) {
    const std::array<std::int64_t, 3> at{i, j, k};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (at[axis] + 1 >= n[axis]) continue;
      const auto next = here + static_cast<std::uint32_t>(step[axis]);
      if (voxels.label[here] == voxels.label[next]) sets.join(here, next);
    }
  });
  std::vector<RegionComponent> found;
  std::vector<std::uint32_t> number(voxels.label.size(), 0xffffffffu);
  for_each([&](std::int64_t i, std::int64_t j, std::int64_t k, std::uint32_t here) {
    const std::uint32_t root = sets.find(here);
    const Box box = voxels.box_of(i, j, k, 1);
    if (number[root] == 0xffffffffu) {
      number[root] = static_cast<std::uint32_t>(found.size());
      found.push_back({.label = voxels.label[here],
                       .bounds = box,
                       .inner = box.centre(),
                       .safe_neighbours = {},
                       .sides = {}});
    }
    RegionComponent& mine = found[number[root]];
    mine.volume += box.size().prod();
    mine.bounds = {mine.bounds.low.cwiseMin(box.low), mine.bounds.high.cwiseMax(box.high)};
  });
  std::vector<std::uint32_t> order(found.size()), rank(found.size()), component(voxels.label.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return found[a].label != found[b].label ? found[a].label < found[b].label
                                            : found[a].volume > found[b].volume;
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    rank[order[i]] = static_cast<std::uint32_t>(i);
    result.components.push_back(std::move(found[order[i]]));
  }
  for (std::uint32_t i = 0; i < component.size(); ++i) component[i] = rank[number[sets.find(i)]];
  find_safe_neighbours(voxels, component, rim, result);
  return component;
}

// Appends the largest cubes of one label. False if the given cube holds more than one label.
bool collect(const Voxels& voxels, const std::vector<std::uint32_t>& component,
             std::array<std::int64_t, 3> low, std::int64_t width, RegionSummary& result) {
  const auto& n = voxels.count;
  if (low[0] >= n[0] || low[1] >= n[1] || low[2] >= n[2]) return true;
  const auto here = static_cast<std::size_t>(voxels.index(low[0], low[1], low[2]));
  if (width == 1) {
    result.leaves.push_back({voxels.box_of(low[0], low[1], low[2], 1), voxels.label[here], component[here]});
    return true;
  }
  const std::size_t start = result.leaves.size();
  bool whole = true;
  for (int child = 0; child < 8; ++child) {
    const std::int64_t half = width / 2;
    const std::size_t before = result.leaves.size();
    const std::array<std::int64_t, 3> part{low[0] + ((child & 1) ? half : 0),
                                           low[1] + ((child & 2) ? half : 0),
                                           low[2] + ((child & 4) ? half : 0)};
    whole = collect(voxels, component, part, half, result) && whole;
    whole = whole && (result.leaves.size() == before || result.leaves.back().label == voxels.label[here]);
  }
  if (!whole) return false;
  result.leaves[start].box = voxels.box_of(low[0], low[1], low[2], width);
  result.leaves.resize(start + 1);
  return true;
}

}  // namespace

RegionSummary sample_regions(const Box& box, double spacing, double rim,
                             const std::function<Label(const Vec3&)>& label) {
  const Voxels voxels = label_voxels(box, spacing, label);
  RegionSummary result;
  const std::vector<std::uint32_t> component = components_of(voxels, rim, result);
  constexpr std::int64_t root = 32;
  for (std::int64_t k = 0; k < voxels.count[2]; k += root)
    for (std::int64_t j = 0; j < voxels.count[1]; j += root)
      for (std::int64_t i = 0; i < voxels.count[0]; i += root)
        collect(voxels, component, {i, j, k}, root, result);
  result.leaf_count = result.leaves.size();
  for (const RegionLeaf& leaf : result.leaves) ++result.components[leaf.component].leaves;
  for (const RegionComponent& c : result.components) {
    result.volume[static_cast<std::size_t>(c.label)] += c.volume;
    ++result.component_count[static_cast<std::size_t>(c.label)];
  }
  return result;
}

}  // namespace forefeel
