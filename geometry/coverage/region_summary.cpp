#include "geometry/coverage/region_summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/common/signed_vector.hpp"
#include "geometry/coverage/voxel_runs.hpp"

namespace forefeel {
namespace {

// ---- safe components next to the others

// Those that share a facet, and for a gap those within its rim: pairs of a component that is not safe and a safe one
// (RegionComponent::safe_neighbours).
using Pair = std::pair<std::uint32_t, std::uint32_t>;
constexpr auto safe_label = static_cast<std::uint8_t>(Label::safe),
               gap_label = static_cast<std::uint8_t>(Label::gap);

class Search {
 public:
  Search(const VoxelLabels& voxels, const VoxelRuns& runs, const RimReach& rim)
      : voxels_(voxels), runs_(runs), rim_of_(rim) {}

  void plane(std::int64_t k) {
    for (std::int64_t j = 0; j < voxels_.count[1]; ++j) {
      const auto row = static_cast<std::size_t>(k * voxels_.count[1] + j);
      for (std::uint32_t run = runs_.first_run(row); run + 1 < runs_.end_run(row); ++run)
        meet(row, run, row, run + 1, runs_.start(run + 1) - 1, 1);
      const auto with = [&](std::size_t other) {
        runs_.for_each_overlap(row, other, [&](std::uint32_t a, std::uint32_t b, std::int32_t i) {
          meet(row, a, other, b, i, 0);
        });
      };
      if (j > 0) with(row - 1);
      if (k > 0) with(row - static_cast<std::size_t>(voxels_.count[1]));
      for (std::uint32_t run = runs_.first_run(row); run < runs_.end_run(row); ++run)
        if (label(row, runs_.start(run)) == gap_label) look_around(j, k, row, run);
    }
    thin_out();
  }
  std::vector<Pair> found;

 private:
  std::uint8_t label(std::size_t row, std::int32_t i) const {
    return voxels_.label[row * static_cast<std::size_t>(voxels_.count[0]) + static_cast<std::size_t>(i)];
  }
  void add(std::uint32_t component, std::uint32_t of_safe) {
    const Pair pair{component, of_safe};
    if (!found.empty() && found.back() == pair) return;
    found.push_back(pair);
    if (found.size() > 2 * thinned_ + (1u << 20)) thin_out();
  }
  void thin_out() {
    std::ranges::sort(found);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    thinned_ = found.size();
  }
  // Runs a and b share a facet where a has voxel i and b voxel i + step.
  void meet(std::size_t row_a, std::uint32_t a, std::size_t row_b, std::uint32_t b, std::int32_t i,
            std::int32_t step) {
    const std::uint8_t la = label(row_a, i), lb = label(row_b, i + step);
    if (la == lb || (la != safe_label && lb != safe_label)) return;
    if (lb == safe_label) add(runs_.component(a), runs_.component(b));
    if (la == safe_label) add(runs_.component(b), runs_.component(a));
  }
  // The safe runs within the rim of a run of a gap. A voxel d voxels away is max(0, |d| - 1) sides away.
  void look_around(std::int64_t j, std::int64_t k, std::size_t row, std::uint32_t run) {
    const std::int32_t first = runs_.start(run), end = runs_.end(row, run);
    const double rim = rim_of_(voxels_.centre_of((first + end) / 2, j, k)) / voxels_.grid.side;  // [voxels]
    const auto reach = static_cast<std::int64_t>(std::floor(rim * (1 + 1e-12))) + 1;
    const auto apart = [](std::int64_t d) {
      return static_cast<double>(std::max<std::int64_t>(0, std::abs(d) - 1));
    };
    for (std::int64_t dk = -reach; dk <= reach; ++dk)
      for (std::int64_t dj = -reach; dj <= reach; ++dj) {
        if (j + dj < 0 || j + dj >= voxels_.count[1] || k + dk < 0 || k + dk >= voxels_.count[2]) continue;
        const double left = rim * rim * (1 + 1e-12) - apart(dj) * apart(dj) - apart(dk) * apart(dk);
        if (left < 0) continue;
        const auto along = static_cast<std::int32_t>(std::floor(std::sqrt(left))) + 1;
        const auto other = static_cast<std::size_t>((k + dk) * voxels_.count[1] + j + dj);
        const std::int32_t from = std::max(0, first - along),
                           to = std::min(static_cast<std::int32_t>(voxels_.count[0]), end + along);
        for (std::uint32_t r = runs_.run_at(other, from); r < runs_.end_run(other) && runs_.start(r) < to;
             ++r)
          if (label(other, runs_.start(r)) == safe_label) add(runs_.component(run), runs_.component(r));
      }
  }

  const VoxelLabels& voxels_;
  const VoxelRuns& runs_;
  const RimReach& rim_of_;
  std::size_t thinned_ = 0;
};

std::vector<Pair> safe_neighbours(const VoxelLabels& voxels, const VoxelRuns& runs, const RimReach& rim) {
  std::vector<Pair> all;
#pragma omp parallel
  {
    Search search(voxels, runs, rim);
#pragma omp for schedule(dynamic, 1)
    for (std::int64_t k = 0; k < voxels.count[2]; ++k) search.plane(k);
#pragma omp critical(forefeel_safe_neighbours)
    all.insert(all.end(), search.found.begin(), search.found.end());
  }
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

// ---- leaves and components

// The low 16 bits of a number, each two places after the one before.
std::uint64_t spread(std::int32_t number) {
  auto bits = static_cast<std::uint64_t>(number) & 0xffff;
  bits = (bits | bits << 16) & 0x0000ff0000ff;
  bits = (bits | bits << 8) & 0x00f00f00f00f;
  bits = (bits | bits << 4) & 0x0c30c30c30c3;
  return (bits | bits << 2) & 0x249249249249;
}

// Increases along the order in which leaves are listed: the root, then the octants from the largest cube down.
std::uint64_t key_of(const RootCubes& roots, const Voxel& v) {
  const std::int32_t within = (1 << roots.level) - 1;
  return static_cast<std::uint64_t>(roots.root_of(v)) << (3 * roots.level) | spread(v[0] & within) |
         spread(v[1] & within) << 1 | spread(v[2] & within) << 2;
}

// Of the leaves of a component: their number, and the largest, the first of several.
struct LeafTally {
  std::uint32_t leaves = 0;
  std::int32_t width = 0;
  std::uint64_t key = 0;
  Voxel low{};

  void take(const LeafTally& other) {
    leaves += other.leaves;
    if (other.width < width || (other.width == width && other.key >= key)) return;
    width = other.width, key = other.key, low = other.low;
  }
};

struct Cube {
  Voxel low{};
  std::int32_t width = 1;
};

class Leaves {
 public:
  Leaves(const VoxelLabels& voxels, const VoxelRuns& runs, const RootCubes& roots)
      : voxels_(voxels), runs_(runs), roots_(roots), tally(runs.components()) {}

  // Lists the leaves of a root in `cubes`.
  void find(std::int32_t root) {
    cubes.clear();
    collect(roots_.low(root), 1 << roots_.level);
    for (const Cube& cube : cubes)
      tally[component(cube)].take(
          {.leaves = 1, .width = cube.width, .key = key_of(roots_, cube.low), .low = cube.low});
  }
  std::uint32_t component(const Cube& cube) const {
    const auto row = static_cast<std::size_t>(cube.low[2] * voxels_.count[1] + cube.low[1]);
    return runs_.component(runs_.run_at(row, cube.low[0]));
  }
  std::vector<Cube> cubes;

 private:
  std::uint8_t label(const Voxel& v) const { return voxels_.label[voxels_.index(v[0], v[1], v[2])]; }
  bool outside(const Voxel& v) const {
    return v[0] >= voxels_.count[0] || v[1] >= voxels_.count[1] || v[2] >= voxels_.count[2];
  }
  // Whether a cube that lies in the box holds one label.
  bool is_whole(const Voxel& low, std::int32_t width) const {
    if (outside({low[0] + width - 1, low[1] + width - 1, low[2] + width - 1})) return false;
    const auto bytes = static_cast<std::size_t>(width);
    const std::uint8_t* const first = voxels_.label.data() + voxels_.index(low[0], low[1], low[2]);
    if (std::memcmp(first, first + 1, bytes - 1) != 0) return false;
    for (std::int32_t k = 0; k < width; ++k)
      for (std::int32_t j = 0; j < width; ++j)
        if (std::memcmp(first, voxels_.label.data() + voxels_.index(low[0], low[1] + j, low[2] + k), bytes) !=
            0)
          return false;
    return true;
  }
  // False if the cube holds more than one label.
  bool collect(const Voxel& low, std::int32_t width) {
    if (outside(low)) return true;
    if (width == 1 || (width >= 4 && is_whole(low, width))) {
      cubes.push_back({low, width});
      return true;
    }
    const std::size_t start = cubes.size();
    bool whole = true;
    const std::int32_t half = width / 2;
    for (int child = 0; child < 8; ++child) {
      const std::size_t before = cubes.size();
      whole = collect({low[0] + (child & 1 ? half : 0), low[1] + (child & 2 ? half : 0),
                       low[2] + (child & 4 ? half : 0)},
                      half) &&
              whole;
      whole = whole && (cubes.size() == before || label(cubes.back().low) == label(low));
    }
    if (!whole) return false;
    cubes.resize(start);
    cubes.push_back({low, width});
    return true;
  }

  const VoxelLabels& voxels_;
  const VoxelRuns& runs_;
  const RootCubes& roots_;

 public:
  std::vector<LeafTally> tally;  // by component
};

// Volumes and bounds. first: the key of the first voxel of each component.
std::vector<RegionComponent> measure(const VoxelLabels& voxels, const VoxelRuns& runs, const RootCubes& roots,
                                     std::vector<std::uint64_t>& first) {
  std::vector<RegionComponent> found(runs.components());
  first.assign(found.size(), ~std::uint64_t{0});
  for (std::size_t row = 0; row < runs.rows(); ++row) {
    const auto j = row % static_cast<std::size_t>(voxels.count[1]),
               k = row / static_cast<std::size_t>(voxels.count[1]);
    const double area = (voxels.high[1][j] - voxels.low[1][j]) * (voxels.high[2][k] - voxels.low[2][k]);
    for (std::uint32_t run = runs.first_run(row); run < runs.end_run(row); ++run) {
      const auto from = static_cast<std::size_t>(runs.start(run)),
                 to = static_cast<std::size_t>(runs.end(row, run)) - 1;
      const std::uint32_t c = runs.component(run);
      RegionComponent& mine = found[c];
      const Vec3 low(voxels.low[0][from], voxels.low[1][j], voxels.low[2][k]),
          high(voxels.high[0][to], voxels.high[1][j], voxels.high[2][k]);
      if (first[c] == ~std::uint64_t{0}) mine.bounds = {low, high};
      mine.label = static_cast<Label>(voxels.label[row * static_cast<std::size_t>(voxels.count[0]) + from]);
      mine.volume += (high.x() - low.x()) * area;
      mine.bounds = {mine.bounds.low.cwiseMin(low), mine.bounds.high.cwiseMax(high)};
      first[c] =
          std::min(first[c], key_of(roots, {static_cast<std::int32_t>(from), static_cast<std::int32_t>(j),
                                            static_cast<std::int32_t>(k)}));
    }
  }
  return found;
}

// The leaves of all components, and of each their number and the middle of the largest.
std::vector<RegionLeaf> find_leaves(const VoxelLabels& voxels, const VoxelRuns& runs, const RootCubes& roots,
                                    bool with_leaves, std::vector<RegionComponent>& components) {
  std::vector<LeafTally> tally(components.size());
  SignedVector<std::vector<RegionLeaf>> of_root;
  if (with_leaves) of_root.resize(static_cast<std::size_t>(roots.size()));
#pragma omp parallel
  {
    Leaves leaves(voxels, runs, roots);
#pragma omp for schedule(dynamic, 8)
    for (std::int32_t root = 0; root < roots.size(); ++root) {
      leaves.find(root);
      if (!with_leaves) continue;
      for (const Cube& cube : leaves.cubes) {
        const std::uint32_t c = leaves.component(cube);
        of_root[root].push_back({voxels.grid.cube(cube.low, cube.width), components[c].label, c});
      }
    }
#pragma omp critical(forefeel_voxel_summary)
    for (std::size_t c = 0; c < tally.size(); ++c) tally[c].take(leaves.tally[c]);
  }
  for (std::size_t c = 0; c < components.size(); ++c) {
    components[c].leaves = tally[c].leaves;
    components[c].inner = voxels.grid.cube(tally[c].low, tally[c].width).centre();
  }
  std::vector<RegionLeaf> all;
  for (std::vector<RegionLeaf>& some : of_root) {
    all.insert(all.end(), some.begin(), some.end());
    std::vector<RegionLeaf>().swap(some);
  }
  return all;
}

}  // namespace

RegionSummary summarise(const VoxelLabels& voxels, const RimReach& rim, bool with_leaves) {
  const VoxelRuns runs(voxels);
  const RootCubes roots(voxels.grid);
  std::vector<std::uint64_t> first;
  std::vector<RegionComponent> found = measure(voxels, runs, roots, first);
  RegionSummary result;
  result.leaves = find_leaves(voxels, runs, roots, with_leaves, found);
  std::vector<std::uint32_t> order(found.size()), rank(found.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    if (found[a].label != found[b].label) return found[a].label < found[b].label;
    if (found[a].volume != found[b].volume) return found[a].volume > found[b].volume;
    return first[a] < first[b];
  });
  for (std::uint32_t i = 0; i < order.size(); ++i) rank[order[i]] = i;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> beside = safe_neighbours(voxels, runs, rim);
  for (auto& [component, safe] : beside) component = rank[component], safe = rank[safe];
  std::ranges::sort(beside);
  for (const std::uint32_t i : order) result.components.push_back(std::move(found[i]));
  for (const auto& [component, safe] : beside) {
    std::vector<std::uint32_t>& known = result.components[component].safe_neighbours;
    if (known.empty() || known.back() != safe) known.push_back(safe);
  }
  for (RegionLeaf& leaf : result.leaves) leaf.component = rank[leaf.component];
  for (const RegionComponent& c : result.components) {
    result.volume[c.label] += c.volume;
    ++result.component_count[c.label];
    result.leaf_count += c.leaves;
  }
  return result;
}

RegionSummary sample_regions(const Box& box, double spacing, double rim,
                             const std::function<Label(const Vec3&)>& label) {
  double total = 1;
  for (const double n : VoxelGrid(box, spacing / 4).count) total *= n;
  if (!(total <= 4e8))
    throw InputError("box", "holds more than 4e8 voxels of h/4, expected a smaller box or a larger spacing");
  VoxelLabels voxels(box, spacing / 4, 0);
#pragma omp parallel for schedule(dynamic)
  for (std::int64_t k = 0; k < voxels.count[2]; ++k)
    for (std::int64_t j = 0; j < voxels.count[1]; ++j)
      for (std::int64_t i = 0; i < voxels.count[0]; ++i)
        voxels.label[voxels.index(i, j, k)] = static_cast<std::uint8_t>(label(voxels.centre_of(i, j, k)));
  return summarise(
      voxels, [rim](const Vec3&) { return rim; }, true);
}

}  // namespace forefeel
