// The safe components next to the others: those that share a facet, and for a gap those within its rim.

#include <algorithm>
#include <cmath>

#include "geometry/coverage/voxel_summary.hpp"

namespace forefeel {
namespace {

using Pair = std::pair<std::uint32_t, std::uint32_t>;
constexpr auto safe = static_cast<std::uint8_t>(Label::safe), gap = static_cast<std::uint8_t>(Label::gap);

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
        if (label(row, runs_.start(run)) == gap) look_around(j, k, row, run);
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
    if (la == lb || (la != safe && lb != safe)) return;
    if (lb == safe) add(runs_.component(a), runs_.component(b));
    if (la == safe) add(runs_.component(b), runs_.component(a));
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
          if (label(other, runs_.start(r)) == safe) add(runs_.component(run), runs_.component(r));
      }
  }

  const VoxelLabels& voxels_;
  const VoxelRuns& runs_;
  const RimReach& rim_of_;
  std::size_t thinned_ = 0;
};

}  // namespace

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

}  // namespace forefeel
